// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file range_scan_file.h

#include <mrpt/obs/CObservation3DRangeScan.h>

namespace superray {

/// Reads the range image and the points that a scan stores externally, in all the formats
/// that MRPT writes, unless they are in memory already. MRPT itself takes a short
/// file for a dark image, and believes every size.
/// \throws std::exception if a file is missing or broken: names it
void loadRangeScan(mrpt::obs::CObservation3DRangeScan& scan);

}  // namespace superray
