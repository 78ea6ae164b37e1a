// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file sensor_survey.h
/// Gathers what is known of each sensor, observation by observation.

#include <mrpt/obs/CObservation.h>
#include <superray/eval/recording_info.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sources/external_folders.h"

namespace superray {

class SensorSurvey {
 public:
    /// \param recording see ExternalFolders
    explicit SensorSurvey(const std::string& recording) : folders_(recording) {}

    void add(const mrpt::obs::CObservation& observation);

    /// By label, then class.
    std::vector<SensorInfo> result() const;
    const ExternalFolders& folders() const { return folders_; }

 private:
    /// So many scans of a sensor are read for its ranges.
    static constexpr std::uint64_t kSampled = 50;

    struct Entry {
        SensorInfo info;
        std::optional<mrpt::Clock::time_point> first, last;
    };
    void addExternalFiles(const mrpt::obs::CObservation& observation, SensorInfo& info) const;
    void addReturns(const mrpt::obs::CObservation& observation, SensorInfo& info) const;

    ExternalFolders folders_;
    std::map<std::pair<std::string, std::string>, Entry> sensors_;
};

}  // namespace superray
