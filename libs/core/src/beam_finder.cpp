#include "beam_finder.h"

#include <superray/core/parallel.h>

#include <cmath>
#include <utility>

#include "walk_kernel.h"

namespace superray {
namespace {

/// Width of a beam at the end of a typical ray [cells], and most rays of one.
constexpr double kWidth = 3;
constexpr std::size_t kMostRays = 16;
/// Rays per beam that make sorting not worth while.
constexpr double kGoodOrder = 8;
/// Bins that one ray repays (clearing and adding up).
constexpr double kBinsPerRay = 1;

template <int Dim>
double typicalLength(const RayDirections<Dim>& directions) {
    const std::size_t rays = directions.kind.size(), step = rays / 256 + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < rays; i += step, ++n)
        sum += static_cast<double>(directions.length[i]);
    return sum / static_cast<double>(n);
}

}  // namespace

template <int Dim>
void BeamFinder<Dim>::find(const RayBundle<Dim>& rays, std::size_t shares) {
    static const FindDirections<Dim> findDirections = bestKernels<Dim>().findDirections;
    const std::size_t count = rays.size();
    directions_.resize(count);
    inParallel(shares, [&](std::size_t s) {
        findDirections(rays, shareBegin(count, s, shares), shareBegin(count, s + 1, shares),
                       directions_);
    });
    const double width = kWidth / std::max(typicalLength(directions_), kWidth);
    sorted_ = false;
    gather(directions_, static_cast<float>(width), shares);
    std::size_t beams = 0;
    for (std::size_t s = 0; s < shares; ++s) beams += beams_[s].size();
    if (static_cast<double>(count) >= kGoodOrder * static_cast<double>(beams)) return;

    const double affordable = kBinsPerRay * static_cast<double>(count);
    const double most = Dim == 2 ? affordable / 32 : std::sqrt(affordable / 32);
    sort(std::max(1, static_cast<int>(std::min(1 / width, most))), shares);
    gather(sortedDirections_, static_cast<float>(1.5 * width), shares);
}

template <int Dim>
void BeamFinder<Dim>::gather(const RayDirections<Dim>& directions, float widest,
                             std::size_t shares) {
    if (beams_.size() < shares) beams_.resize(shares);
    const std::size_t count = directions.kind.size();
    inParallel(shares, [&](std::size_t s) {
        gather(directions, widest, shareBegin(count, s, shares),
               shareBegin(count, s + 1, shares), beams_[s]);
    });
}

/// Makes beams of consecutive rays.
template <int Dim>
void BeamFinder<Dim>::gather(const RayDirections<Dim>& d, float widest, std::size_t begin,
                             std::size_t end, std::vector<BeamRays<Dim>>& beams) {
    beams.clear();
    const auto count = static_cast<std::uint32_t>(end);
    for (auto i = static_cast<std::uint32_t>(begin); i < count;) {
        BeamRays<Dim> beam{i, i + 1, d.kind[i], d.length[i], {}, {}};
        for (int m = 0; m < Dim - 1; ++m) beam.low[m] = beam.high[m] = d.slope[m][i];
        const auto most = std::min<std::size_t>(count, i + kMostRays);
        if (beam.kind != RayDirections<Dim>::kLone) {
            for (; beam.end < most && d.kind[beam.end] == beam.kind; ++beam.end) {
                float low[Dim - 1], high[Dim - 1];
                bool narrow = true;
                for (int m = 0; m < Dim - 1; ++m) {
                    const float s = d.slope[m][beam.end];
                    low[m] = std::min(beam.low[m], s);
                    high[m] = std::max(beam.high[m], s);
                    narrow &= high[m] - low[m] <= widest;
                }
                if (!narrow) break;
                std::copy(low, low + Dim - 1, beam.low);
                std::copy(high, high + Dim - 1, beam.high);
                beam.length = std::max(beam.length, d.length[beam.end]);
            }
        }
        beams.push_back(beam);
        i = beam.end;
    }
}

/// Counting sort by kind and slopes; each share counts and places its own rays.
template <int Dim>
void BeamFinder<Dim>::sort(int bins, std::size_t shares) {
    const RayDirections<Dim>& d = directions_;
    const std::size_t count = d.kind.size();
    const auto firstOf = [&](std::size_t share) { return shareBegin(count, share, shares); };
    std::size_t all = RayDirections<Dim>::kLone;
    for (int m = 0; m < Dim - 1; ++m) all *= static_cast<std::size_t>(bins);
    bins_.resize(count);
    order_.resize(count);
    sortedDirections_.resize(count);
    if (starts_.size() < shares) starts_.resize(shares);

    const auto scale = static_cast<float>(bins);
    inParallel(shares, [&](std::size_t s) {
        std::vector<std::uint32_t>& rays = starts_[s];  // per bin
        rays.assign(all, 0);
        for (std::size_t i = firstOf(s); i < firstOf(s + 1); ++i) {
            // A lone ray goes with those of its kind 0.
            std::uint32_t bin = d.kind[i] % RayDirections<Dim>::kLone;
            for (int m = 0; m < Dim - 1; ++m) {
                const auto b = static_cast<std::int32_t>(d.slope[m][i] * scale);
                bin = bin * static_cast<std::uint32_t>(bins) +
                      static_cast<std::uint32_t>(std::min(b, bins - 1));
            }
            bins_[i] = bin;
            ++rays[bin];
        }
    });
    std::uint32_t start = 0;
    for (std::size_t b = 0; b < all; ++b)
        for (std::size_t s = 0; s < shares; ++s) start += std::exchange(starts_[s][b], start);
    inParallel(shares, [&](std::size_t s) {
        for (std::size_t i = firstOf(s); i < firstOf(s + 1); ++i) {
            const std::uint32_t at = starts_[s][bins_[i]]++;
            order_[at] = static_cast<std::uint32_t>(i);
            sortedDirections_.kind[at] = d.kind[i];
            sortedDirections_.length[at] = d.length[i];
            for (int m = 0; m < Dim - 1; ++m) sortedDirections_.slope[m][at] = d.slope[m][i];
        }
    });
    sorted_ = true;
}

template class BeamFinder<2>;
template class BeamFinder<3>;

}  // namespace superray
