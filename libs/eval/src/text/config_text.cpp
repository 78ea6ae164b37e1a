// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/config_text.h>
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <vector>

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

bool isComment(const std::string& name) {
    return !name.empty() && (name[0] == '#' || name[0] == ';' || startsWith(name, "//"));
}

/// Lines as MRPT counts them.
std::vector<std::string> linesOf(const std::string& text) {
    std::vector<std::string> lines(1);
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool beforeLineFeed = i + 1 < text.size() && text[i + 1] == '\n';
        if (text[i] == '\r' && beforeLineFeed) continue;
        if (text[i] == '\n' || text[i] == '\r')
            lines.emplace_back();
        else
            lines.back() += text[i];
    }
    return lines;
}

class ConfigCheck {
 public:
    ConfigCheck(const std::string& path, const std::function<bool(const std::string&)>& isRead)
        : path_(path), isRead_(isRead) {}

    void run(const std::string& text) {
        const char* const kByteOrderMark = "\xEF\xBB\xBF";
        const auto lines = linesOf(startsWith(text, kByteOrderMark) ? text.substr(3) : text);
        for (number_ = 1; number_ <= lines.size(); ++number_)
            if (lines[number_ - 1].find('\0') != std::string::npos)
                fail("has a NUL character: what follows it would not be read");
        for (std::size_t i = 0; i < lines.size(); ++i) {
            number_ = i + 1;
            // MRPT joins a line that ends in a backslash with the next one, comments too.
            std::string line = lines[i];
            while (!line.empty() && line.back() == '\\' && i + 1 < lines.size()) {
                line.pop_back();
                checkJoined(line, nameIn(lines[i + 1]));
                line += lines[++i];
            }
            check(nameIn(line));
        }
    }

 private:
    [[noreturn]] void fail(const std::string& what) const {
        throw InputError(path_ + ":" + std::to_string(number_) + ": " + what);
    }

    void checkJoined(const std::string& line, const std::string& next) const {
        const bool comment = isComment(nameIn(line)) || withoutComment(line) != line;
        if (!comment || next.empty() || isComment(next)) return;
        if (isOurs_ || next[0] == '[')
            fail("a comment that ends in '\\' takes the next line with it");
    }

    void check(const std::string& line) {
        if (line.empty() || isComment(line) || startsWith(line, "@define")) return;
        if (line[0] == '[') return checkSection(line);
        const auto equals = line.find('=');
        const std::string key = nameIn(line.substr(0, equals));
        const std::string shown = "'" + shortened(line) + "' ";
        if (section_.empty()) fail(shown + "stands before any section: it would not be read");
        if (equals != std::string::npos && !keys_.insert(key).second)
            fail("second key '" + shortened(key) + "' in section " + section_);
        if (!isOurs_ || line[0] == '$') return;  // what a variable stands for is not known here
        if (equals == std::string::npos || key.empty())
            fail(shown + "must be 'key = value': it would not be read");
    }

    void checkSection(const std::string& line) {
        const auto end = line.find(']');
        if (end == std::string::npos)
            fail("'" + shortened(line) + "' must be a section in brackets: ']' is missing");
        section_ = nameIn(line.substr(0, end + 1));
        keys_.clear();
        isOurs_ = isRead_(nameIn(line.substr(1, end - 1)));
        if (!sections_.insert(section_).second) fail("second section " + shortened(section_));
        const std::string rest = nameIn(line.substr(end + 1));
        if (isOurs_ && !rest.empty() && !isComment(rest))
            fail("'" + shortened(rest) + "' after a section's name would not be read");
    }

    const std::string& path_;
    const std::function<bool(const std::string&)>& isRead_;
    std::size_t number_ = 0;
    std::set<std::string> sections_, keys_;
    std::string section_;
    bool isOurs_ = false;
};

}  // namespace

mrpt::config::CConfigFileMemory readConfigFile(
    const std::string& path, const std::function<bool(const std::string&)>& isRead) {
    const std::string text = openTextInput(path, LastLine::any).str();
    ConfigCheck(path, isRead).run(text);
    mrpt::config::CConfigFileMemory config;
    try {
        config.setContent(text);
    } catch (const std::exception& e) {  // of variables and expressions
        throw InputError(path + ": " + oneLineCause(e));
    }
    return config;
}

}  // namespace superray
