// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file map_info.h
/// What there is to know about a map, for people and for programs.

#include <superray/maps/super_ray_map_interface.h>

#include <string>

namespace superray {

/// Aligned lines of text.
std::string infoAsText(const SuperRayMapInterface& map, const std::string& path);

/// One JSON object:
/// `file`, `class`, `dimension`, `resolution` [m], `cells` {known, occupied,
/// free}, `bounds` {min, max} [m] or null, `memory_bytes`, `digest`, `options`
/// {section: {key: text}}.
std::string infoAsJson(const SuperRayMapInterface& map, const std::string& path);

/// A JSON string with its quotes. Bytes that are not UTF-8 become U+FFFD.
std::string jsonString(const std::string& text);

}  // namespace superray
