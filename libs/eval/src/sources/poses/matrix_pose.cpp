// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/matrix_pose.h"

#include <mrpt/math/CMatrixFixed.h>
#include <superray/eval/input_error.h>

namespace superray {

using Eigen::Isometry3d;

Isometry3d fromRowMajor(const std::vector<double>& v, const std::string& where) {
    if (v.size() != 12)
        throw InputError(where + ": has " + std::to_string(v.size()) +
                         " numbers, a 3x4 matrix has 12");
    Isometry3d T = Isometry3d::Identity();
    for (int row = 0; row < 3; ++row)
        for (int col = 0; col < 4; ++col)
            T.matrix()(row, col) = v[static_cast<std::size_t>(4 * row + col)];
    const Eigen::Matrix3d R = T.linear();
    if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0)
        throw InputError(where + ": the left 3x3 part of the matrix is not a rotation" +
                         (R.determinant() < 0 ? " (a mirror)" : ""));
    return T;
}

mrpt::poses::CPose3D toPose(const Isometry3d& T) {
    mrpt::math::CMatrixDouble44 m;
    for (int row = 0; row < 4; ++row)
        for (int col = 0; col < 4; ++col) m(row, col) = T.matrix()(row, col);
    return mrpt::poses::CPose3D(m);
}

}  // namespace superray
