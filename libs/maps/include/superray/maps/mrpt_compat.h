// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file mrpt_compat.h
/// Everything that depends on the MRPT version lives here. Tested with 2.5.8
/// (Debian 12), 2.14.7 (Debian 13) and 2.15.14 (Debian sid).

#include <mrpt/img/TColor.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDF.h>
#include <mrpt/version.h>

#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

// MRPT_VERSION is 0x258 for 2.5.8, and 0x020A02 for 2.10.2 and later.
// The module of things to draw is mrpt::viz from 3.0 on. (There, mrpt::opengl draws them.)
#if MRPT_VERSION >= 0x030000
#include <mrpt/viz/COctoMapVoxels.h>
#include <mrpt/viz/CSetOfObjects.h>
#include <mrpt/viz/Scene.h>
#else
#include <mrpt/opengl/COctoMapVoxels.h>
#include <mrpt/opengl/CSetOfObjects.h>
#if MRPT_VERSION >= 0x270
#include <mrpt/opengl/Scene.h>
#else
#include <mrpt/opengl/COpenGLScene.h>
#endif
#endif

// CVoxelMap exists from 2.11.0 on.
#if MRPT_VERSION >= 0x020B00
#define SUPERRAY_HAS_MRPT_VOXEL_MAP 1
#else
#define SUPERRAY_HAS_MRPT_VOXEL_MAP 0
#endif

// CMetricMap::boundingBox() is virtual from 2.11.3 on.
#if MRPT_VERSION >= 0x020B03
#define SUPERRAY_OVERRIDE_SINCE_2_11_3 override
#else
#define SUPERRAY_OVERRIDE_SINCE_2_11_3
#endif

// NearestNeighborsCapable exists from 2.11.3 on.
#if MRPT_VERSION >= 0x020B03
#define SUPERRAY_HAS_MRPT_NEAREST_NEIGHBORS 1
#include <mrpt/maps/NearestNeighborsCapable.h>
#else
#define SUPERRAY_HAS_MRPT_NEAREST_NEIGHBORS 0
#endif

namespace superray {

#if SUPERRAY_HAS_MRPT_NEAREST_NEIGHBORS
using NearestNeighborsBase = mrpt::maps::NearestNeighborsCapable;
#else
/// In the place of an interface that MRPT does not have yet.
class NearestNeighborsBase {
 public:
    virtual ~NearestNeighborsBase() = default;
};
#endif

#if MRPT_VERSION >= 0x030000
namespace mrpt_viz = mrpt::viz;
#else
namespace mrpt_viz = mrpt::opengl;
#endif

#if MRPT_VERSION >= 0x270
using GlScene = mrpt_viz::Scene;
#else
using GlScene = mrpt_viz::COpenGLScene;
#endif

/// A colour of mrpt::img::colormap(), which has one of floats from 3.0 on.
template <class Color>
mrpt::img::TColor toColor(const Color& color) {
    if constexpr (std::is_same_v<Color, mrpt::img::TColor>) {
        return color;
    } else {
        return color.asTColor();
    }
}

/// True if MRPT's own streams read (and write) zstd: 2.15.7 and later.
constexpr bool kMrptReadsZstd = MRPT_VERSION >= 0x020F07;

/// What MRPT's map creators return: a raw pointer, or a std::shared_ptr from
/// 2.11.3 on.
using MapCreatorResult = decltype(std::declval<mrpt::maps::internal::MapCtorFromDefFunctor>()(
    std::declval<const mrpt::maps::TMetricMapInitializer&>()));

/// True if CObservationRotatingScan carries points (`organizedPoints`), as it
/// does in later 2.x.
template <class Scan, class = void>
struct HasOrganizedPoints : std::false_type {};
template <class Scan>
struct HasOrganizedPoints<Scan,
                          std::void_t<decltype(std::declval<const Scan&>().organizedPoints)>>
    : std::true_type {};

/// True if this scan has points. MRPT leaves the matrix empty where it has none.
template <class Scan>
bool hasOrganizedPoints(const Scan& scan) {
    if constexpr (HasOrganizedPoints<Scan>::value) {
        return scan.organizedPoints.rows() > 0 && scan.organizedPoints.cols() > 0;
    } else {
        return false;
    }
}

/// True if a points map may have a channel of times: that of CPointsMapXYZIRT before
/// 2.15.0.
template <class Points, class = void>
struct HasTimestampChannel : std::false_type {};
template <class Points>
struct HasTimestampChannel<
    Points, std::void_t<decltype(std::declval<const Points&>().getPointsBufferRef_timestamp())>>
    : std::true_type {};

/// True if a points map may have channels by name, as CGenericPointsMap and, from then
/// on, CPointsMapXYZIRT: since 2.15.0.
template <class Points, class = void>
struct HasNamedChannels : std::false_type {};
template <class Points>
struct HasNamedChannels<
    Points,
    std::void_t<decltype(std::declval<const Points&>().getPointsBufferRef_float_field("t"))>>
    : std::true_type {};

/// When each point was measured [s], as the cloud has it: after the time stamp of its
/// observation. Empty if it does not tell.
template <class Points>
std::vector<float> pointTimes(const Points& cloud) {
    if constexpr (HasNamedChannels<Points>::value) {
        if (const auto* times = cloud.getPointsBufferRef_float_field("t"))
            return {times->begin(), times->end()};
    } else if constexpr (HasTimestampChannel<Points>::value) {
        if (const auto* times = cloud.getPointsBufferRef_timestamp())
            return {times->begin(), times->end()};
    }
    return {};
}

/// False if this MRPT cannot read rotating scans that earlier ones wrote: 2.11.4 changed
/// their stream, but not its version number. (Trying takes minutes.)
#if MRPT_VERSION < 0x020B04
inline constexpr bool kReadsEarlierRotatingScans = true;
#else
inline constexpr bool kReadsEarlierRotatingScans = false;
#endif

/// One pose of a CSimpleMap, with what was observed there. Either may be null.
struct KeyFrameParts {
    std::shared_ptr<const mrpt::poses::CPose3DPDF> pose;
    std::shared_ptr<const mrpt::obs::CSensoryFrame> observations;
};

/// \param index < map.size()
inline KeyFrameParts keyFrameParts(const mrpt::maps::CSimpleMap& map, std::size_t index) {
    // A pair until 2.11.4; since then a struct, which also has a twist.
#if MRPT_VERSION >= 0x020B05
    const auto& frame = map.get(index);
    return {frame.pose, frame.sf};
#else
    const auto [pose, observations] = map.get(index);
    return {pose, observations};
#endif
}

/// True if assigning through a CPointsMap& asks the points map what to do. From 2.13.2
/// on it clears the map and inserts the bare points of the other one.
#if MRPT_VERSION < 0x020D02
inline constexpr bool kAssignmentAsksThePointsMap = true;
#else
inline constexpr bool kAssignmentAsksThePointsMap = false;
#endif

/// A points map that decides what assigning another points map to it does, where MRPT
/// asks; see kAssignmentAsksThePointsMap.
class AssignablePointsMap : public mrpt::maps::CSimplePointsMap {
 protected:
    AssignablePointsMap() = default;
    /// Called by assignments through a CPointsMap&, if MRPT asks.
    virtual void assignFrom(const mrpt::maps::CPointsMap& other) = 0;
    /// Coordinates and options, without a call of clear().
    void copyPoints(const CSimplePointsMap& other) {
        insertionOptions = other.insertionOptions;
        likelihoodOptions = other.likelihoodOptions;
        renderOptions = other.renderOptions;
        genericMapParams = other.genericMapParams;
        m_x = other.getPointsBufferRef_x();
        m_y = other.getPointsBufferRef_y();
        m_z = other.getPointsBufferRef_z();
        mark_as_modified();
    }

 private:
#if MRPT_VERSION < 0x020D02
    void impl_copyFrom(const mrpt::maps::CPointsMap& other) final {
        assignFrom(other);
    }
#endif
};

}  // namespace superray
