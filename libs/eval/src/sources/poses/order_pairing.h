// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file order_pairing.h
/// Which pose belongs to which scan where time stamps cannot tell.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sources/poses/pose_streams.h"

namespace superray {

/// Of each scan, by its order in the recording: the index of its pose.
using PosesByOrder = std::map<std::uint64_t, std::size_t>;

/// Pairs scans with poses by their order in the recording:
///  - a pose in the same frame belongs to it (the last one before the scan);
///  - else, if a pose comes first, the one before the scan;
///  - else, if a pose comes last, the one after it.
/// \param poses,scans by their order; poses not empty
/// \throws InputError, naming `what`, if that does not tell: scans come first and last,
///         or one sensor has several scans to one pose
PosesByOrder pairByOrder(const std::vector<PoseEntry>& poses,
                         const std::vector<ScanPlace>& scans, const std::string& what);

}  // namespace superray
