// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The kernels of one instruction set.

#include "kernels/generic/at_least.h"
#include "kernels/generic/choose_rays.h"
#include "kernels/generic/classify_rays.h"
#include "kernels/generic/copy_points.h"
#include "kernels/generic/find_runs.h"
#include "kernels/generic/mark_boundary.h"
#include "kernels/generic/walk_ends.h"
#include "kernels/generic/walk_line.h"
#include "kernels/generic/walk_rays.h"
#include "kernels/walk_kernel.h"

namespace superray {
namespace {

/// The kernel that is faster for few slices; without lanes there is none.
template <typename Simd, int Dim>
WalkRays<Dim> walkEndsKernel() {
    if constexpr (Simd::kWalksLanes)
        return walkEnds<Simd, Dim>;
    else
        return walkRays<Simd, Dim>;
}

template <typename Simd, int Dim>
WalkKernels<Dim> kernelTable() {
    WalkKernels<Dim> kernels;
    kernels.walk = walkLine<Simd, Dim>;
    kernels.walkRays = walkRays<Simd, Dim>;
    kernels.walkEnds = walkEndsKernel<Simd, Dim>();
    kernels.classifyRays = classifyRays<Simd, Dim>;
    kernels.findRuns = findRuns<Simd, Dim>;
    kernels.chooseRays = chooseRays<Simd>;
    kernels.atLeast = atLeast<Simd, Dim>;
    kernels.markBoundary = markBoundary<Simd, Dim>;
    kernels.copyFloats = copyPoints<Simd, Dim, float>;
    kernels.copyDoubles = copyPoints<Simd, Dim, double>;
    return kernels;
}

}  // namespace
}  // namespace superray
