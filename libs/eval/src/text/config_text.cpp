// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/config_text.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "text/text_input.h"

namespace superray {
namespace {

/// Without blanks at both ends, in lower case: as MRPT compares names.
std::string nameIn(const std::string& text) {
    const char* const kBlanks = " \t\r";
    const auto first = text.find_first_not_of(kBlanks);
    if (first == std::string::npos) return {};
    std::string name = text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return name;
}

}  // namespace

std::string readConfigText(const std::string& path) {
    std::istringstream lines = openTextInput(path, LastLine::any);
    std::set<std::string> sections, keys;
    std::string section;
    std::size_t number = 1;
    for (std::string line; std::getline(lines, line); ++number) {
        const std::string name = nameIn(line);
        if (name.empty() || name[0] == '#' || name[0] == ';' || name.rfind("//", 0) == 0)
            continue;
        const auto fail = [&](const std::string& what) {
            throw InputError(path + ":" + std::to_string(number) + ": " + what);
        };
        if (name[0] == '[') {
            section = nameIn(name.substr(0, name.find(']') + 1));
            keys.clear();
            if (!sections.insert(section).second) fail("second section " + section);
        } else if (const auto equals = name.find('='); equals != std::string::npos) {
            const std::string key = nameIn(name.substr(0, equals));
            if (!keys.insert(key).second)
                fail("second key '" + key + "' in section " + section);
        }
    }
    return lines.str();
}

}  // namespace superray
