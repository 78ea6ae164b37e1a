// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file memory_limit_error.h
/// What is thrown before a map would hold more memory than it may.

#include <cstddef>
#include <stdexcept>
#include <string>

namespace superray {

/// A change that would take a map beyond its memory bound. The map is as it was before.
class MemoryLimitError : public std::runtime_error {
 public:
    /// All in bytes. \param needed what the map would hold, at most
    /// \param text what was refused, with the way out
    MemoryLimitError(std::size_t limit, std::size_t held, std::size_t needed,
                     const std::string& text)
        : std::runtime_error(text), limit_(limit), held_(held), needed_(needed) {}

    std::size_t limit() const { return limit_; }    ///< the bound [bytes]
    std::size_t held() const { return held_; }      ///< what the map holds now [bytes]
    std::size_t needed() const { return needed_; }  ///< what it would hold, at most [bytes]

 private:
    std::size_t limit_, held_, needed_;
};

}  // namespace superray
