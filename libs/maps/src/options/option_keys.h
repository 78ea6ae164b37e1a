// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The one list of keys per section: loading, saving and text all follow it.

#include <superray/maps/options.h>

#include <type_traits>

namespace superray {

// visit(key, member, comment)

template <class O, class Visit>
void visitCreation(O& o, Visit visit) {
    visit("resolution", o.resolution, "[m] cell edge");
    visit("load_from", o.load_from, "native map file to start from");
    visit("lazy_load_path", o.lazy_load_path, "folder of externally stored observations");
    visit("reserve_megabytes", o.reserve_megabytes, "memory to take beforehand");
    visit("max_memory_megabytes", o.max_memory_megabytes, "bound of its memory, 0: none");
    visit("enableSaveAs3DObject", o.enableSaveAs3DObject, "show this map");
    visit("enableObservationLikelihood", o.enableObservationLikelihood, "use its likelihood");
    visit("enableObservationInsertion", o.enableObservationInsertion, "insert into it");
}

template <class O, class Visit>
void visitInsertion(O& o, Visit visit) {
    visit("maxrange", o.maxrange, "[m] longer rays are cut, <= 0: no limit");
    visit("minrange", o.minrange, "[m] nearer returns are skipped");
    visit("probHit", o.probHit, "in (0.5, 1)");
    visit("probMiss", o.probMiss, "in (0, 0.5)");
    visit("scanHitMax", o.scanHitMax, "in (0.5, 1), netEvidence: most that a scan says");
    visit("scanMissMin", o.scanMissMin, "in (0, 0.5), netEvidence: most that a scan says");
    visit("clampingThresMin", o.clampingThresMin, "in (0, 0.5)");
    visit("clampingThresMax", o.clampingThresMax, "in (0.5, 1)");
    visit("occupancyThres", o.occupancyThres, "in (0, 1)");
    visit("policy", o.policy, "netEvidence, everyRay, oncePerScan");
    visit("method", o.method, "reference, perRay, superRays, culling, full, auto");
    visit("superRayThreshold", o.superRayThreshold, "fewer points in a cell: not grouped");
    visit("threads", o.threads, ">= 1");
    visit("decimation", o.decimation, "use one of so many measurements");
    visit("insertNoReturnRays", o.insertNoReturnRays, "measurements without return clear");
    visit("noReturnRange", o.noReturnRange, "[m] their length, <= 0: sensor's maximum");
    visit("sweepDuration", o.sweepDuration, "[s] of a 2D scan, for de-skewing");
    visit("sensorLabel", o.sensorLabel, "comma-separated, empty: all");
    visit("horizontalTolerance", o.horizontalTolerance, "[deg] planar scans in 2D maps");
    visit("clearAtMaxrange", o.clearAtMaxrange, "the cell where maxrange cuts, too");
    visit("heightBandMin", o.heightBandMin, "[m] map frame");
    visit("heightBandMax", o.heightBandMax, "[m] map frame");
    visit("windowRadius", o.windowRadius, "[m] farther cells are forgotten, 0: none");
    visit("pointStatistics", o.pointStatistics, "surface in the cells, for matching");
}

template <class O, class Visit>
void visitLikelihood(O& o, Visit visit) {
    visit("decimation", o.decimation, "use one of so many measurements");
    visit("sigma", o.sigma, "[m] of the distance to an occupied cell");
    visit("maxDistance", o.maxDistance, "[m] farther is as bad as this");
    visit("uniformWeight", o.uniformWeight, "in [0, 1), share of returns anywhere");
    visit("unknownLikelihood", o.unknownLikelihood, "in (0, 1], a hit has 1");
}

template <class O, class Visit>
void visitRendering(O& o, Visit visit) {
    visit("generateGridLines", o.generateGridLines, "edges of all drawn cells");
    visit("generateOccupiedVoxels", o.generateOccupiedVoxels, "");
    visit("visibleOccupiedVoxels", o.visibleOccupiedVoxels, "");
    visit("generateFreeVoxels", o.generateFreeVoxels, "many");
    visit("visibleFreeVoxels", o.visibleFreeVoxels, "");
    visit("colour", o.colour, "height, occupancy");
}

template <class O, class Visit>
void visitOptions(O& o, Visit visit) {
    using Options = std::remove_const_t<O>;
    if constexpr (std::is_same_v<Options, TCreationOptions>) visitCreation(o, visit);
    if constexpr (std::is_same_v<Options, TInsertionOptions>) visitInsertion(o, visit);
    if constexpr (std::is_same_v<Options, TLikelihoodOptions>) visitLikelihood(o, visit);
    if constexpr (std::is_same_v<Options, TRenderingOptions>) visitRendering(o, visit);
}

}  // namespace superray
