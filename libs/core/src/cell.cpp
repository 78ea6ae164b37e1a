// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/cell.h>

#include <charconv>
#include <stdexcept>

namespace superray {

std::string metresText(double metres) {
    char text[32];
    return std::string(text, std::to_chars(text, text + sizeof text, metres).ptr) + " m";
}

template <int Dim>
CellGeometry<Dim>::CellGeometry(double resolution)
    : resolution_(resolution), inverse_(1.0 / resolution) {
    if (isResolution(resolution)) return;
    throw std::invalid_argument("resolution = " + metresText(resolution) + ": must be " +
                                kResolutionRule);
}

template class CellGeometry<2>;
template class CellGeometry<3>;

}  // namespace superray
