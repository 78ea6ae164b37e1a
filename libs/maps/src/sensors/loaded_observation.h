#pragma once
/// \file loaded_observation.h

#include <mrpt/obs/CObservation.h>

#include "sensors/external_file.h"

namespace superray {

/// Loads externally stored data for its lifetime.
class LoadedObservation {
 public:
    /// \param unloadAfter the data were not in memory before
    LoadedObservation(const mrpt::obs::CObservation& observation, bool unloadAfter)
        : observation_(observation), unloadAfter_(unloadAfter) {
        loadExternalData(observation_);
    }
    ~LoadedObservation() {
        if (unloadAfter_) observation_.unload();
    }
    LoadedObservation(const LoadedObservation&) = delete;
    LoadedObservation& operator=(const LoadedObservation&) = delete;

 private:
    const mrpt::obs::CObservation& observation_;
    bool unloadAfter_;
};

}  // namespace superray
