// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/config/CConfigFileMemory.h>
#include <superray/eval/map_info.h>
#include <superray/eval/progress_meter.h>

#include <charconv>
#include <cstdio>
#include <sstream>
#include <vector>

namespace superray {
namespace {

/// The shortest text that reads back to the same double.
std::string number(double value) {
    char text[40];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return std::string(text, end);
}

/// Coordinates that the map has, in brackets.
std::string coordinates(const Eigen::Vector3d& p, int dimension) {
    std::string text = "[";
    for (int i = 0; i < dimension; ++i) text += (i > 0 ? ", " : "") + number(p[i]);
    return text + "]";
}

/// The same for people: bounds are multiples of the resolution.
std::string rounded(const Eigen::Vector3d& p, int dimension) {
    std::ostringstream text;
    for (int i = 0; i < dimension; ++i) text << (i > 0 ? ", " : "[") << p[i];
    return text.str() + "]";
}

/// Bytes of the UTF-8 sequence that starts at `at`, 0 if it is not one.
std::size_t utf8Length(const std::string& text, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const unsigned first = byte(at);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
    if (first < 0xC2 || first > 0xF4) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(at + i) & 0xC0) != 0x80) return 0;
    // Overlong forms, surrogates, and beyond U+10FFFF.
    const unsigned second = byte(at + 1);
    if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ||
        (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F))
        return 0;
    return length;
}

std::string optionsAsJson(const std::string& iniText) {
    mrpt::config::CConfigFileMemory ini;
    ini.setContent(iniText);
    std::vector<std::string> sections, keys;
    ini.getAllSections(sections);
    std::string json = "{";
    for (std::size_t s = 0; s < sections.size(); ++s) {
        json += (s > 0 ? ",\n    " : "\n    ") + jsonString(sections[s]) + ": {";
        ini.getAllKeys(sections[s], keys);
        for (std::size_t k = 0; k < keys.size(); ++k)
            json += (k > 0 ? ", " : "") + jsonString(keys[k]) + ": " +
                    jsonString(ini.read_string(sections[s], keys[k], ""));
        json += "}";
    }
    return json + "\n  }";
}

}  // namespace

std::string jsonString(const std::string& text) {
    std::string json = "\"";
    for (std::size_t i = 0; i < text.size();) {
        const char c = text[i];
        const std::size_t length = utf8Length(text, i);
        if (length == 0) {
            json += "\\ufffd";
        } else if (c == '"' || c == '\\') {
            json += {'\\', c};
        } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
            char escaped[8];
            std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned>(c));
            json += escaped;
        } else {
            json.append(text, i, length);
        }
        i += std::max<std::size_t>(length, 1);
    }
    return json + "\"";
}

std::string infoAsText(const SuperRayMapInterface& map, const std::string& path) {
    const auto cells = map.cellTotals();
    const auto bounds = map.metricBounds();
    std::ostringstream out;
    out << "file        " << path << "\n"
        << "class       " << map.shortClassName() << " (" << map.dimension() << "D)\n"
        << "resolution  " << number(map.resolution()) << " m\n"
        << "cells       " << formatCount(cells.known)
        << " known: " << formatCount(cells.occupied) << " occupied, " << formatCount(cells.free)
        << " free\n"
        << "bounds      ";
    if (bounds)
        out << rounded(bounds->lowest, map.dimension()) << " to "
            << rounded(bounds->highest, map.dimension()) << " m\n";
    else
        out << "none, the map is empty\n";
    out << "memory      " << formatBytes(map.memoryBytes()) << "\n"
        << "digest      " << map.digest() << "\n"
        << "options\n\n"
        << map.optionsAsIniText();
    return out.str();
}

std::string infoAsJson(const SuperRayMapInterface& map, const std::string& path) {
    const auto cells = map.cellTotals();
    const auto bounds = map.metricBounds();
    std::ostringstream out;
    out << "{\n  \"file\": " << jsonString(path)
        << ",\n  \"class\": " << jsonString(map.shortClassName())
        << ",\n  \"dimension\": " << map.dimension()
        << ",\n  \"resolution\": " << number(map.resolution())
        << ",\n  \"cells\": {\"known\": " << cells.known << ", \"occupied\": " << cells.occupied
        << ", \"free\": " << cells.free << "},\n  \"bounds\": ";
    if (bounds)
        out << "{\"min\": " << coordinates(bounds->lowest, map.dimension())
            << ", \"max\": " << coordinates(bounds->highest, map.dimension()) << "}";
    else
        out << "null";
    out << ",\n  \"memory_bytes\": " << map.memoryBytes()
        << ",\n  \"digest\": " << jsonString(map.digest())
        << ",\n  \"options\": " << optionsAsJson(map.optionsAsIniText()) << "\n}\n";
    return out.str();
}

}  // namespace superray
