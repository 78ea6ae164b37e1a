// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file external_file.h
/// Scans whose data are in files of their own, beside the recording.

#include <mrpt/obs/CObservation.h>

namespace superray {

/// Loads the externally stored data of an observation, if it has any: what
/// CObservation::load() does, and zstd files on every version of MRPT.
/// \throws std::exception if a file is missing or broken: names it
void loadExternalData(const mrpt::obs::CObservation& observation);

}  // namespace superray
