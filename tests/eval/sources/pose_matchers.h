// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file pose_matchers.h
/// Poses are compared by their matrices: angles are not unique.

#include <gtest/gtest.h>
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/poses/CPose3D.h>

#include <Eigen/Dense>

namespace superray::test {

inline void expectPoseNear(const mrpt::poses::CPose3D& pose,
                           const mrpt::poses::CPose3D& expected, double tolerance = 1e-9) {
    const auto matrix = [](const mrpt::poses::CPose3D& p) {
        return p.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>().asEigen().eval();
    };
    EXPECT_LE((matrix(pose) - matrix(expected)).cwiseAbs().maxCoeff(), tolerance)
        << pose.asString() << " instead of " << expected.asString();
}

}  // namespace superray::test
