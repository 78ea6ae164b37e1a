// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Adds up what several threads have counted.

#include "counting/scan_counts.h"

#include <cstddef>

namespace superray {

/// What becomes of blocks that the sum has no counts of yet.
enum class NewBlocks {
    copied,   ///< into the sum
    borrowed  ///< the sum refers to the counts where they are; nothing can be added later
};

/// Adds the counts of `from` to those of `to`, in up to `threads` threads.
template <int Dim>
void mergeCounts(ScanCounts<Dim>& to, const ScanCounts<Dim>& from, NewBlocks newBlocks,
                 std::size_t threads);

}  // namespace superray
