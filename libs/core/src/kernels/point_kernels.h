// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Points into a bundle: what the kernels of an instruction set do.

#include <superray/core/cell.h>

#include <array>

namespace superray {

/// Where points go, and bounds to extend.
template <int Dim, typename Scalar>
struct PointBatch {
    std::array<Scalar*, static_cast<std::size_t>(Dim)> coordinates;
    Point<Dim> lowest, highest;  ///< [m]
};

/// Copies `count` points. \param inverse cells per metre
/// \return false if one of them is not addressable; then what was written does
/// not matter
template <int Dim, typename Scalar>
using CopyPoints = bool (*)(const Scalar* points, std::size_t count, double inverse,
                            PointBatch<Dim, Scalar>& to);

}  // namespace superray
