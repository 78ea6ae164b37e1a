#include "direction_order.h"

#include <cmath>
#include <cstdlib>

namespace superray {
namespace {

/// Width of a bin at the end of a typical ray [cells].
double kBinCells = getenv("BINC") ? atof(getenv("BINC")) : 2.0;
/// Bins that one ray repays (clearing and adding up).
double kBinsPerRay = 4;

/// Mean length along the dominant axis of some of the rays [cells].
template <int Dim>
double typicalSlices(const RayBundle<Dim>& rays) {
    const std::size_t step = rays.size() / 256 + 1;
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < rays.size(); i += step, ++n)
        sum += (rays.end(i) - rays.commonOrigin()).cwiseAbs().maxCoeff();
    return rays.geometry().scaled(sum / static_cast<double>(n));
}

}  // namespace

template <int Dim>
void DirectionOrder<Dim>::sort(const RayBundle<Dim>& rays) {
    static const DirectionBins<Dim> directionBins = bestKernels<Dim>().directionBins;
    const double affordable = kBinsPerRay * static_cast<double>(rays.size());
    const double most = Dim == 2 ? affordable / 8 : std::sqrt(affordable / 24);
    static double cap = getenv("BINMAX") ? atof(getenv("BINMAX")) : 1e9;
    const double wanted = typicalSlices(rays) / kBinCells;
    const int bins = std::max(1, static_cast<int>(std::min({wanted, most, cap})));

    bins_.resize(rays.size());
    directionBins(rays, bins, bins_.data());
    starts_.assign(static_cast<std::size_t>(directionBinCount<Dim>(bins)) + 1, 0);
    for (const std::uint32_t bin : bins_) ++starts_[bin + 1];
    for (std::size_t b = 1; b < starts_.size(); ++b) starts_[b] += starts_[b - 1];
    order_.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i)
        order_[starts_[bins_[i]]++] = static_cast<std::uint32_t>(i);
}

template class DirectionOrder<2>;
template class DirectionOrder<3>;

}  // namespace superray
