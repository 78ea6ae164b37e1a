// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file option_text.h
/// Values of options as text, and strict reading of .ini sections.

#include <mrpt/config/CConfigFileBase.h>
#include <superray/maps/options.h>

#include <cstdint>
#include <string>
#include <vector>

namespace superray {

/// Text that reads back to the same bits.
std::string formatValue(double value);
std::string formatValue(bool value);
std::string formatValue(std::uint32_t value);
/// \throws std::invalid_argument for control characters, which .ini text cannot hold
std::string formatValue(const std::string& value);
std::string formatValue(UpdatePolicy value);
std::string formatValue(Method value);
std::string formatValue(VoxelColour value);

/// \throws std::invalid_argument with the rule only, e.g. "must be a number"
void parseValue(const std::string& text, double& value);
void parseValue(const std::string& text, bool& value);
void parseValue(const std::string& text, std::uint32_t& value);
void parseValue(const std::string& text, std::string& value);
void parseValue(const std::string& text, UpdatePolicy& value);
void parseValue(const std::string& text, Method& value);
void parseValue(const std::string& text, VoxelColour& value);

/// The entries of a comma-separated list, without blanks around them; empty ones are left out.
std::vector<std::string> splitList(const std::string& text);

/// The candidate with the fewest edits from `word`, ignoring case.
std::string closestTo(const std::string& word, const std::vector<std::string>& candidates);

/// What stands before a comment ("value  # comment", also with "//" and ";", after a blank).
std::string withoutComment(const std::string& text);

/// A text as errors show it: cut if it is long.
std::string shortened(const std::string& text);
/// A text of a file as a terminal may have it: control characters by their codes (x1b).
std::string printable(const std::string& text);

bool equalIgnoringCase(const std::string& a, const std::string& b);
bool startsWith(const std::string& text, const std::string& start);

/// A section of key = value lines whose every key must be known.
class StrictSection {
 public:
    struct Entry {
        std::string key, value;
        bool used = false;
    };

    StrictSection(std::string name, std::vector<Entry> entries)
        : name_(std::move(name)), entries_(std::move(entries)) {}
    StrictSection(const mrpt::config::CConfigFileBase& source, const std::string& name);

    /// Parses the value of `key` if present; keys match without regard to case.
    /// \throws std::invalid_argument naming section, key, value and rule
    template <class T>
    void read(const std::string& key, T& value) {
        knownKeys_.push_back(key);
        for (Entry& e : entries_) {
            if (e.used || !equalIgnoringCase(e.key, key)) continue;
            e.used = true;
            try {
                parseValue(e.value, value);
            } catch (const std::invalid_argument& rule) {
                failBadValue(e, rule.what());
            }
        }
    }

    /// Whether the section has this key, read or not.
    bool has(const std::string& key) const;

    /// To be called after all read().
    /// \throws std::invalid_argument naming an unread key and the closest known one
    void rejectUnknownKeys() const;

 private:
    [[noreturn]] void failBadValue(const Entry& entry, const std::string& rule) const;

    std::string name_;
    std::vector<Entry> entries_;
    std::vector<std::string> knownKeys_;
};

}  // namespace superray
