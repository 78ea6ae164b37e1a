// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/cell.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace superray {

template <int Dim>
CellGeometry<Dim>::CellGeometry(double resolution)
    : resolution_(resolution), inverse_(1.0 / resolution) {
    if (!(std::isfinite(resolution) && resolution > 0 && std::isfinite(inverse_)))
        throw std::invalid_argument("resolution = " + std::to_string(resolution) +
                                    " m: must be finite and > 0");
}

template class CellGeometry<2>;
template class CellGeometry<3>;

}  // namespace superray
