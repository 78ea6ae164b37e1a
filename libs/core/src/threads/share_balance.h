#pragma once
// How to share out a scan, going by the last one.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace superray {

/// Where shares of a scan begin, so that each is as much work as the others if things are
/// in the same order as in the last scan, and as much work each.
class ShareBalance {
 public:
    /// Begins a scan of so many shares: equal ones, unless the last scan had as many.
    void begin(std::size_t shares) {
        if (shares == count()) return;
        begin_.resize(shares + 1);
        for (std::size_t s = 0; s <= shares; ++s)
            begin_[s] = static_cast<double>(s) / static_cast<double>(shares);
    }
    /// First of `n` things that belong to a share; of shares in a row, those of the
    /// next one begin where the ones before end. \pre share <= number of shares
    std::size_t first(std::size_t n, std::size_t share) const {
        return static_cast<std::size_t>(std::lround(begin_[share] * static_cast<double>(n)));
    }
    /// What work each of the shares was. \pre work.size() is their number
    void learn(const std::vector<double>& work) {
        double sum = 0;
        for (const double w : work) sum += w;
        if (!(sum > 0)) return;
        const std::vector<double> old = begin_;
        const double each = sum / static_cast<double>(count());
        double before = 0;  // work of the old shares before `s`
        for (std::size_t s = 0, share = 1; share < count(); ++share) {
            const double wanted = each * static_cast<double>(share);
            while (s + 1 < count() && before + work[s] < wanted) before += work[s++];
            // As if the work of a share were spread over it evenly.
            const double part = work[s] > 0 ? std::min(1.0, (wanted - before) / work[s]) : 0.0;
            begin_[share] = old[s] + part * (old[s + 1] - old[s]);
        }
    }

 private:
    std::size_t count() const { return begin_.size() - 1; }

    std::vector<double> begin_{0, 1};  // of each share, and the end: parts of the whole
};

}  // namespace superray
