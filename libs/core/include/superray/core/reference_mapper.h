// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file reference_mapper.h
/// The oracle: one ray at a time, one cell at a time. Everything else must
/// equal it bit for bit (design rule 6).

#include <superray/core/cell_counts.h>
#include <superray/core/ray_bundle.h>
#include <superray/core/sensor_model.h>

#include <map>

namespace superray {

/// Counts of every cell that the rays of a scan miss or hit, ray by ray.
template <int Dim>
CellCountMap<Dim> countCells(const RayBundle<Dim>& rays);

/// A map as simple as it can be: ordered cells and their log-odds.
template <int Dim>
class ReferenceMapper {
 public:
    explicit ReferenceMapper(const SensorModel& model,
                             UpdatePolicy policy = UpdatePolicy::everyRay)
        : model_(model), policy_(policy) {}

    void insert(const RayBundle<Dim>& rays);
    const std::map<Cell<Dim>, float>& cells() const { return cells_; }

 private:
    SensorModel model_;
    UpdatePolicy policy_;
    std::map<Cell<Dim>, float> cells_;
};

extern template class ReferenceMapper<2>;
extern template class ReferenceMapper<3>;

}  // namespace superray
