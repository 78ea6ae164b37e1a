#pragma once
// Points into a bundle: one kernel per instruction set.

#include <superray/core/cell.h>

#include <array>

namespace superray {

/// Where points go, and bounds to extend.
template <int Dim>
struct PointBatch {
    std::array<double*, static_cast<std::size_t>(Dim)> coordinates;
    Point<Dim> lowest, highest;  ///< [m]
};

/// Copies `count` points. \param inverse cells per metre
/// \return false if one of them is not addressable; then what was written does
/// not matter
template <int Dim, typename Scalar>
using CopyPoints = bool (*)(const Scalar* points, std::size_t count, double inverse,
                            PointBatch<Dim>& to);

template <int Dim>
struct PointKernels {
    CopyPoints<Dim, float> copyFloats;
    CopyPoints<Dim, double> copyDoubles;
    CopyPoints<Dim, float> copy(float) const { return copyFloats; }
    CopyPoints<Dim, double> copy(double) const { return copyDoubles; }
};

template <int Dim>
PointKernels<Dim> portablePointKernels();
/// \pre the processor has the instructions
template <int Dim>
PointKernels<Dim> avx2PointKernels();
template <int Dim>
PointKernels<Dim> avx512PointKernels();
/// The fastest of this processor, see bestKernels().
template <int Dim>
PointKernels<Dim> bestPointKernels();

}  // namespace superray
