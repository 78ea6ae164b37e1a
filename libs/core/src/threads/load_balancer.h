// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Chunks of a scan that are equal work, by the work of the last scan.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace superray {

/// Chooses where the chunks of a scan begin. They are equal work if this scan is like the last
/// one: the same order of rays, and as much work for each part of them.
class LoadBalancer {
 public:
    /// Begins a scan of so many chunks: of equal size, unless the last scan had as many.
    void begin(std::size_t chunks) {
        if (chunks == count()) return;
        begin_.resize(chunks + 1);
        for (std::size_t s = 0; s <= chunks; ++s)
            begin_[s] = static_cast<double>(s) / static_cast<double>(chunks);
    }
    /// First of `n` elements that belong to a chunk, which ends where the next one begins.
    /// \pre chunk <= number of chunks
    std::size_t first(std::size_t n, std::size_t chunk) const {
        return static_cast<std::size_t>(std::lround(begin_[chunk] * static_cast<double>(n)));
    }
    /// Learns how much work each chunk was. \pre work.size() is their number
    void learn(const std::vector<double>& work) {
        double sum = 0;
        for (const double w : work) sum += w;
        if (!(sum > 0)) return;
        const std::vector<double> old = begin_;
        const double each = sum / static_cast<double>(count());
        double before = 0;  // work of the old chunks before `s`
        for (std::size_t s = 0, chunk = 1; chunk < count(); ++chunk) {
            const double wanted = each * static_cast<double>(chunk);
            while (s + 1 < count() && before + work[s] < wanted) before += work[s++];
            // As if the work of a chunk were spread over it evenly.
            const double part = work[s] > 0 ? std::min(1.0, (wanted - before) / work[s]) : 0.0;
            begin_[chunk] = old[s] + part * (old[s + 1] - old[s]);
        }
    }

 private:
    std::size_t count() const { return begin_.size() - 1; }

    std::vector<double> begin_{0, 1};  // of each chunk, and the end: parts of the whole
};

}  // namespace superray
