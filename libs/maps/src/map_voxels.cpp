#include <mrpt/img/color_maps.h>

#include <algorithm>
#include <cmath>

#include "map_export.h"

namespace superray {
namespace {

using mrpt::opengl::COctoMapVoxels;

/// 2D maps are drawn as cubes centred on z = 0.
template <int Dim>
mrpt::math::TPoint3Df centerOf(const Cell<Dim>& cell, const CellGeometry<Dim>& geometry) {
    const Point<Dim> p = geometry.center(cell);
    return {static_cast<float>(p[0]), static_cast<float>(p[1]),
            Dim == 3 ? static_cast<float>(p[Dim - 1]) : 0.0f};
}

/// Colour scale over [low, high].
struct ColourScale {
    double low, high;
    mrpt::img::TColor operator()(double value) const {
        const double t = high > low ? (value - low) / (high - low) : 1.0;
        return mrpt::img::colormap(mrpt::img::cmJET,
                                   static_cast<float>(std::clamp(t, 0.0, 1.0)));
    }
};

template <int Dim, class F>
void forEachCell(const OccupancyMap<Dim>& map, F f) {
    map.forEachBlock([&](const BlockView<Dim>& block) {
        for (int i = 0; i < kBlockCells<Dim>; ++i)
            if (block.known.test(i)) f(cellInBlock<Dim>(block.key, i), block.values[i]);
    });
}

}  // namespace

template <int Dim>
std::shared_ptr<COctoMapVoxels> makeVoxels(const OccupancyMap<Dim>& map,
                                           const SensorModel& model,
                                           const TRenderingOptions& options) {
    const auto& geometry = map.geometry();
    auto voxels = COctoMapVoxels::Create();
    const bool byHeight = options.colour == VoxelColour::height;
    voxels->setVisualizationMode(byHeight ? COctoMapVoxels::COLOR_FROM_HEIGHT
                                          : COctoMapVoxels::COLOR_FROM_OCCUPANCY);
    voxels->enableCubeTransparency(false);
    voxels->showGridLines(options.generateGridLines);
    voxels->resizeVoxelSets(2);
    voxels->showVoxels(mrpt::opengl::VOXEL_SET_OCCUPIED, options.visibleOccupiedVoxels);
    voxels->showVoxels(mrpt::opengl::VOXEL_SET_FREESPACE, options.visibleFreeVoxels);

    const auto isDrawn = [&](float value) {
        return value >= model.occupied() ? options.generateOccupiedVoxels
                                         : options.generateFreeVoxels;
    };
    Cell<Dim> lowest, highest;
    lowest.fill(kCellLimit);
    highest.fill(-kCellLimit);
    std::size_t drawn = 0;
    forEachCell(map, [&](const Cell<Dim>& c, float value) {
        if (!isDrawn(value)) return;
        ++drawn;
        for (int a = 0; a < Dim; ++a) {
            lowest[a] = std::min(lowest[a], c[a]);
            highest[a] = std::max(highest[a], c[a]);
        }
    });
    if (drawn == 0) return voxels;

    const ColourScale heightColour{centerOf(lowest, geometry).z, centerOf(highest, geometry).z};
    const ColourScale occupancyColour{probabilityOf(model.min()), probabilityOf(model.max())};
    const double edge = geometry.resolution();
    const auto half = static_cast<float>(edge / 2);
    const mrpt::math::TPoint3Df halfCell(half, half, half);
    voxels->reserveVoxels(mrpt::opengl::VOXEL_SET_OCCUPIED,
                          options.generateFreeVoxels ? 0 : drawn);
    if (options.generateGridLines) voxels->reserveGridCubes(drawn);
    forEachCell(map, [&](const Cell<Dim>& c, float value) {
        if (!isDrawn(value)) return;
        const auto p = centerOf(c, geometry);
        const auto colour =
            byHeight ? heightColour(p.z) : occupancyColour(probabilityOf(value));
        const auto set = value >= model.occupied() ? mrpt::opengl::VOXEL_SET_OCCUPIED
                                                   : mrpt::opengl::VOXEL_SET_FREESPACE;
        voxels->push_back_Voxel(set, {p, edge, colour});
        if (options.generateGridLines) voxels->push_back_GridCube({p - halfCell, p + halfCell});
    });
    const auto low = centerOf(lowest, geometry) - halfCell;
    const auto high = centerOf(highest, geometry) + halfCell;
    voxels->setBoundingBox({low.x, low.y, low.z}, {high.x, high.y, high.z});
    return voxels;
}

template std::shared_ptr<COctoMapVoxels> makeVoxels(const OccupancyMap<2>&, const SensorModel&,
                                                    const TRenderingOptions&);
template std::shared_ptr<COctoMapVoxels> makeVoxels(const OccupancyMap<3>&, const SensorModel&,
                                                    const TRenderingOptions&);

}  // namespace superray
