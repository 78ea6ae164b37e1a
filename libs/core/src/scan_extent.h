#pragma once
// Cell bounds of a scan.

#include <superray/core/ray_bundle.h>

#include "block_directory.h"

namespace superray {

/// Inclusive cell bounds of all origins and end points. \pre !rays.empty()
template <int Dim>
struct ScanExtent {
    Cell<Dim> lowest, highest;
    explicit ScanExtent(const RayBundle<Dim>& rays) {
        Point<Dim> low = rays.origin(0), high = low;
        const auto include = [&](const Point<Dim>& p) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        };
        for (std::size_t i = 0; i < rays.size(); ++i) include(rays.end(i));
        if (!rays.hasCommonOrigin())
            for (std::size_t i = 0; i < rays.size(); ++i) include(rays.origin(i));
        lowest = rays.geometry().cellOf(low);
        highest = rays.geometry().cellOf(high);
    }
    BlockBox<Dim> blocks() const { return {blockOf<Dim>(lowest), blockOf<Dim>(highest)}; }
};

}  // namespace superray
