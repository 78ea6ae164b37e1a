// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/option_text.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <limits>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace superray {
namespace {

char lower(char c) {
    return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

std::string lowered(std::string s) {
    std::transform(s.begin(), s.end(), s.begin(), lower);
    return s;
}

bool isBlank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

std::string trimmed(const std::string& s) {
    const auto first = std::find_if_not(s.begin(), s.end(), isBlank);
    const auto last = std::find_if_not(s.rbegin(), s.rend(), isBlank).base();
    return first < last ? std::string(first, last) : std::string();
}

/// Levenshtein distance.
std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replace = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replace, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

template <class T>
void parseNumber(const std::string& text, T& value, const char* rule) {
    T parsed{};
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, parsed);
    if (result.ec != std::errc() || result.ptr != end) throw std::invalid_argument(rule);
    value = parsed;
}

}  // namespace

std::string formatValue(double value) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
    return std::string(buffer, end);
}

std::string formatValue(bool value) {
    return value ? "true" : "false";
}
std::string formatValue(std::uint32_t value) {
    return std::to_string(value);
}

std::string formatValue(const std::string& value) {
    const auto refuse = [&](const char* rule) {
        throw std::invalid_argument("\"" + shortened(value) + "\": a text option must " + rule);
    };
    if (std::any_of(value.begin(), value.end(),
                    [](char c) { return std::iscntrl(static_cast<unsigned char>(c)); }))
        refuse("have no control character");
    // What a configuration file would not give back.
    if (value != trimmed(value)) refuse("not begin or end with a blank");
    if (value != withoutComment(value)) refuse("not begin a comment (#, ; or //)");
    for (const char* command : {"${", "$env{", "$eval{", "@define"})
        if (value.find(command) != std::string::npos)
            refuse("have none of ${, $env{, $eval{ and @define, which MRPT replaces");
    return value;
}

std::string formatValue(UpdatePolicy value) {
    return toString(value);
}
std::string formatValue(Method value) {
    return toString(value);
}
std::string formatValue(VoxelColour value) {
    return value == VoxelColour::height ? "height" : "occupancy";
}

void parseValue(const std::string& text, double& value) {
    // from_chars accepts no leading '+', people do.
    const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
    parseNumber(plus ? text.substr(1) : text, value, "must be a number");
}

void parseValue(const std::string& text, bool& value) {
    const std::string t = lowered(text);
    if (t == "true" || t == "yes" || t == "1") {
        value = true;
    } else if (t == "false" || t == "no" || t == "0") {
        value = false;
    } else {
        throw std::invalid_argument("must be true or false");
    }
}

void parseValue(const std::string& text, std::uint32_t& value) {
    parseNumber(text, value, "must be a whole number >= 0");
}

void parseValue(const std::string& text, std::string& value) {
    value = text;
}

void parseValue(const std::string& text, UpdatePolicy& value) {
    for (const auto p : kUpdatePolicies) {
        if (text != toString(p)) continue;
        value = p;
        return;
    }
    throw std::invalid_argument("must be " + updatePolicyNames());
}

void parseValue(const std::string& text, Method& value) {
    std::string names;
    for (const auto m : {Method::reference, Method::perRay, Method::superRays, Method::culling,
                         Method::full, Method::automatic}) {
        if (text == toString(m)) {
            value = m;
            return;
        }
        names += (names.empty() ? "" : ", ") + std::string(toString(m));
    }
    throw std::invalid_argument("must be one of " + names);
}

void parseValue(const std::string& text, VoxelColour& value) {
    for (const auto c : {VoxelColour::height, VoxelColour::occupancy}) {
        if (text != formatValue(c)) continue;
        value = c;
        return;
    }
    throw std::invalid_argument("must be height or occupancy");
}

std::string closestTo(const std::string& word, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (const auto& candidate : candidates) {
        const std::size_t edits = editDistance(lowered(word), lowered(candidate));
        if (edits >= fewest) continue;
        fewest = edits;
        best = candidate;
    }
    return best;
}

std::string withoutComment(const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (i > 0 && !isBlank(text[i - 1])) continue;
        if (text[i] == '#' || text[i] == ';' || text.compare(i, 2, "//") == 0)
            return text.substr(0, i);
    }
    return text;
}

std::string shortened(const std::string& text) {
    constexpr std::size_t kMost = 100;
    if (text.size() <= kMost) return text;
    std::size_t length = kMost;
    const auto continuesUtf8 = [](char c) {
        return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
    };
    while (length > kMost - 4 && continuesUtf8(text[length])) --length;
    return text.substr(0, length) + "... (" + std::to_string(text.size()) + " characters)";
}

std::string printable(const std::string& text) {
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        char code[8];
        std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned>(byte));
        result += std::iscntrl(byte) ? std::string(code) : std::string(1, c);
    }
    return result;
}

bool equalIgnoringCase(const std::string& a, const std::string& b) {
    return a.size() == b.size() &&
           std::equal(a.begin(), a.end(), b.begin(),
                      [](char x, char y) { return lower(x) == lower(y); });
}

bool startsWith(const std::string& text, const std::string& start) {
    return text.compare(0, start.size(), start) == 0;
}

StrictSection::StrictSection(const mrpt::config::CConfigFileBase& source,
                             const std::string& name)
    : name_(name) {
    std::vector<std::string> keys;
    source.getAllKeys(name, keys);
    for (const auto& key : keys) {
        const std::string value = source.read_string(name, key, "");
        // MRPT pads keys with blanks when it writes them.
        entries_.push_back({trimmed(key), trimmed(withoutComment(value)), false});
    }
}

std::vector<std::string> splitList(const std::string& text) {
    std::vector<std::string> entries;
    std::istringstream list(text);
    for (std::string entry; std::getline(list, entry, ',');) {
        entry = trimmed(entry);
        if (!entry.empty()) entries.push_back(entry);
    }
    return entries;
}

bool StrictSection::has(const std::string& key) const {
    return std::any_of(entries_.begin(), entries_.end(),
                       [&](const Entry& e) { return equalIgnoringCase(e.key, key); });
}

void StrictSection::rejectUnknownKeys() const {
    for (const Entry& e : entries_) {
        if (e.used) continue;
        throw std::invalid_argument("[" + name_ + "] " + shortened(e.key) + " = " +
                                    shortened(e.value) + ": unknown key; did you mean " +
                                    closestTo(e.key, knownKeys_) + "?");
    }
}

void StrictSection::failBadValue(const Entry& entry, const std::string& rule) const {
    throw std::invalid_argument("[" + name_ + "] " + entry.key + " = " +
                                shortened(entry.value) + ": " + rule);
}

}  // namespace superray
