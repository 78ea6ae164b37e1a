// SPDX-License-Identifier: BSD-3-Clause
#include "sources/poses/pose_columns.h"

#include <superray/eval/input_error.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <initializer_list>
#include <set>

namespace superray {
namespace {

using Words = std::vector<std::string>;

bool isBracket(char c) {
    return c == '[' || c == '(';
}

/// Words of a line without units, "[m]" or "(rad)".
Words namesOf(const std::string& line, const char* separators) {
    Words names;
    auto begin = line.find_first_not_of(separators);
    while (begin != std::string::npos) {
        const auto end = std::min(line.find_first_of(separators, begin), line.size());
        std::string name = line.substr(begin, end - begin);
        const bool isUnit =
            isBracket(name.front()) && name.find_first_of("])") != std::string::npos;
        while (!name.empty() && isBracket(name.front())) name.erase(0, 1);
        name = name.substr(0, name.find_first_of("[("));
        const auto last = name.find_last_not_of(" \t\r])");
        if (!isUnit && last != std::string::npos) names.push_back(name.substr(0, last + 1));
        begin = line.find_first_not_of(separators, end);
    }
    return names;
}

std::string lowerCase(const std::string& name) {
    std::string lower;
    for (const char c : name)
        lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return lower;
}

bool hasAny(const std::string& text, std::initializer_list<const char*> parts) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const char* part) { return text.find(part) != std::string::npos; });
}

/// What a name says: x, y, z, w, yaw, pitch or roll; nothing for other names.
/// "q_RS_w" and "pose.position.x" are such names, "index" and "by" are none.
std::string partOf(const std::string& name) {
    const std::string lower = lowerCase(name);
    for (const char* angle : {"yaw", "pitch", "roll"}) {
        const std::size_t length = std::strlen(angle);
        if (lower.size() >= length && lower.compare(lower.size() - length, length, angle) == 0)
            return angle;
    }
    const char axis = lower.back();
    if (axis < 'w' || axis > 'z') return {};
    const std::string kind = lower.substr(0, lower.size() - 1);
    const bool isKnown = kind.size() <= 1
                             ? kind.find_first_not_of("tpqr") == std::string::npos
                             : std::ispunct(static_cast<unsigned char>(kind.back())) != 0 ||
                                   hasAny(kind, {"pos", "trans", "quat", "orient", "rot"});
    return isKnown ? std::string(1, axis) : std::string();
}

/// The same, with axes of rotations told from those of places: "qx", "rx".
std::string fullPartOf(const std::string& name) {
    std::string part = partOf(name), lower = lowerCase(name);
    if (part.size() != 1) return part;
    if (lower == "r" + part) return lower;
    const bool isQuaternion =
        lower.front() == 'q' || part == "w" || hasAny(lower, {"quat", "orient", "rot"});
    return (isQuaternion ? "q" : "") + part;
}

bool isOrder(const Words& parts) {
    const std::multiset<std::string> all(parts.begin(), parts.end());
    return all == std::multiset<std::string>{"x", "y", "z", "qx", "qy", "qz", "qw"} ||
           all == std::multiset<std::string>{"x", "y", "z", "yaw", "pitch", "roll"} ||
           all == std::multiset<std::string>{"x", "y", "z", "rx", "ry", "rz"};
}

std::string joined(const Words& words) {
    std::string text;
    for (const auto& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

}  // namespace

void PoseColumns::seeComment(const std::string& line, const std::string& where) {
    Words names, parts;
    const auto end = [&] {
        if (isOrder(parts)) orders_.push_back({where, names});
        names.clear();
        parts.clear();
    };
    for (const auto& name : namesOf(line, " \t\r,;:=#%")) {
        if (partOf(name).empty()) {
            end();
        } else {
            names.push_back(name);
            parts.push_back(fullPartOf(name));
        }
    }
    end();
}

void PoseColumns::seeHeading(const std::string& line, const std::string& where) {
    const bool hasCommas = line.find_first_of(",;") != std::string::npos;
    heading_ = {where, namesOf(line, hasCommas ? ",;" : " \t\r")};
    for (auto& name : heading_.words) name.erase(0, name.find_first_not_of(" \t"));
    seeComment(line, where);
}

void PoseColumns::check(const Words& read) const {
    if (heading_.words.size() == read.size()) {
        for (std::size_t i = 0; i < read.size(); ++i) {
            const std::string part = partOf(heading_.words[i]);
            if (!part.empty() && part != partOf(read[i]))
                throw InputError(heading_.where + ": column " + std::to_string(i + 1) +
                                 " is '" + heading_.words[i] + "', read as " + read[i] +
                                 ": columns must be " + joined(read));
        }
        return;
    }
    const Words place(read.begin() + 1, read.end());
    const auto isRead = [&](const Names& order) {
        return std::equal(order.words.begin(), order.words.end(), place.begin(), place.end(),
                          [](const auto& a, const auto& b) { return fullPartOf(a) == b; });
    };
    if (!orders_.empty() && std::none_of(orders_.begin(), orders_.end(), isRead))
        throw InputError(orders_.front().where + ": names the order " +
                         joined(orders_.front().words) + ", read as " + joined(place) +
                         ": columns must be " + joined(read));
}

}  // namespace superray
