// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Loops that may or may not change something at each step.

#include <cstddef>

namespace superray {

/// How to leave out what changes nothing: by a branch, which costs nothing where
/// nearly all steps go the same way, or not at all. A store that changes nothing
/// is not free: a step that needs the same value next waits for it.
enum class Branches { predicted, none };

/// Which of them is faster for the next steps, going by the last ones.
class BranchChoice {
 public:
    bool unpredictable() const { return unpredictable_; }
    void learn(std::size_t changes, std::size_t steps) {
        unpredictable_ = 10 * changes > steps;
    }

 private:
    bool unpredictable_ = true;
};

}  // namespace superray
