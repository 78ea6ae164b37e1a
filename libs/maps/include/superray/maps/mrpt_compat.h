#pragma once
/// \file mrpt_compat.h
/// Everything that depends on the MRPT version lives here. Written and tested
/// against 2.5.8; the branches for later 2.x follow their headers.

#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/version.h>

#include <type_traits>
#include <utility>

// MRPT_VERSION is 0x258 for 2.5.8, and 0x020A02 for 2.10.2 and later.
#if MRPT_VERSION >= 0x270
#include <mrpt/opengl/Scene.h>
#else
#include <mrpt/opengl/COpenGLScene.h>
#endif

// CMetricMap::boundingBox() is virtual from 2.11.3 on.
#if MRPT_VERSION >= 0x020B03
#define SUPERRAY_OVERRIDE_SINCE_2_11_3 override
#else
#define SUPERRAY_OVERRIDE_SINCE_2_11_3
#endif

namespace superray {

#if MRPT_VERSION >= 0x270
using GlScene = mrpt::opengl::Scene;
#else
using GlScene = mrpt::opengl::COpenGLScene;
#endif

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

}  // namespace superray
