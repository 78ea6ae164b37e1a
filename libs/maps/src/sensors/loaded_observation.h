// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file loaded_observation.h

#include <mrpt/obs/CObservation.h>

#include <functional>
#include <memory>

namespace superray {

/// Externally stored data of an observation, in memory for this object's lifetime.
///
/// Any number of threads may hold the same observation: the first one loads it, and
/// the last one unloads it. What the caller had loaded before stays in memory.
class LoadedObservation {
 public:
    /// \param isLoaded whether the external data are in memory now; asked while no
    ///        other holder loads or unloads
    /// \throws what CObservation::load() throws, e.g. if the file is missing
    LoadedObservation(const mrpt::obs::CObservation& observation,
                      const std::function<bool()>& isLoaded);
    ~LoadedObservation();
    LoadedObservation(const LoadedObservation&) = delete;
    LoadedObservation& operator=(const LoadedObservation&) = delete;

 private:
    struct Readers;
    class Registry;

    void release() noexcept;

    const mrpt::obs::CObservation& observation_;
    std::shared_ptr<Readers> readers_;
};

}  // namespace superray
