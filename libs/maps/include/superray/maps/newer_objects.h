// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file newer_objects.h
/// Objects of MRPT 2.15 for an older MRPT.

#include <mrpt/serialization/CSerializable.h>
#include <superray/maps/compressed_input.h>

namespace superray {

/// The next object of a file. Reads what the installed MRPT reads and, where that is
/// older than 2.15, also the layouts that 2.15 writes for: CObservation2DRangeScan,
/// CSimplePointsMap (alone and in CObservationPointCloud), the same in a
/// CSensoryFrame, and CSimpleMap. What older versions have no place for is left out
/// (the duration of a sweep, the twist of a keyframe); no map depends on it.
/// \throws std::exception as CArchive::ReadObject() does
mrpt::serialization::CSerializable::Ptr readObject(CompressedInput& file);

}  // namespace superray
