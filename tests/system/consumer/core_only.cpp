// SPDX-License-Identifier: BSD-3-Clause
#include <superray/core/reference_mapper.h>

#include <iostream>

int main() {
    superray::RayBundle<2> rays(superray::CellGeometry<2>(1.0), {0.5, 0.5});
    rays.add({3.5, 0.5});
    superray::ReferenceMapper<2> mapper{superray::SensorModel()};
    mapper.insert(rays);
    std::cout << mapper.cells().size() << " cells\n";
}
