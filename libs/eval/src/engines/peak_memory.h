// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file peak_memory.h

#include <cstdint>
#include <functional>
#include <optional>

namespace superray {

/// By how many bytes the memory of a process (resident set) grows at most while
/// it does `work`: a copy of this process does it. Nothing if it cannot be told.
std::optional<std::uint64_t> peakGrowth(const std::function<void()>& work);

/// Resident set of this process [bytes]; 0 if it cannot be told.
std::uint64_t residentBytes();

}  // namespace superray
