// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file nearest_occupied.h

#include <superray/storage/occupancy_map.h>

#include <optional>
#include <vector>

namespace superray {

/// Finds the occupied cell nearest to a point by looking at the cells around it,
/// nearest first.
template <int Dim>
class NearestOccupied {
 public:
    /// Never looks farther than this many cells: the work grows with its cube.
    static constexpr int kMaxCells = 32;

    struct Found {
        Cell<Dim> cell;
        double distance;  ///< from the point to the cell [m], 0 inside
    };

    /// \param occupied log-odds from which a cell is occupied
    /// \param radius [m] cells farther away are not found; < 0 or NaN: none is
    NearestOccupied(const OccupancyMap<Dim>& map, float occupied, double radius);

    /// \pre map.geometry().contains(p)
    std::optional<Found> operator()(const Point<Dim>& p) const;

 private:
    struct Offset {
        Cell<Dim> cell;
        double atLeast;  ///< distance from anywhere in the centre cell [m]
    };

    const OccupancyMap<Dim>& map_;
    float occupied_;
    double radius_;
    std::vector<Offset> offsets_;
};

extern template class NearestOccupied<2>;
extern template class NearestOccupied<3>;

}  // namespace superray
