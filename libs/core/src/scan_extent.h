#pragma once
// Cell bounds of a scan.

#include <superray/core/ray_bundle.h>

#include "block_directory.h"

namespace superray {

/// Inclusive cell bounds of all origins and end points. \pre !rays.empty()
template <int Dim>
struct ScanExtent {
    Cell<Dim> lowest, highest;
    explicit ScanExtent(const RayBundle<Dim>& rays)
        : lowest(rays.geometry().cellOf(rays.lowest())),
          highest(rays.geometry().cellOf(rays.highest())) {}
    BlockBox<Dim> blocks() const { return {blockOf<Dim>(lowest), blockOf<Dim>(highest)}; }
};

}  // namespace superray
