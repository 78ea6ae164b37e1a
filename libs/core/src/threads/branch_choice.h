// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Skips no-op stores by a branch, or always stores: whichever is faster now.

#include <cstddef>

namespace superray {

/// What a loop does with a store that would change nothing.
///   predicted: skips it by a branch; free where nearly all steps go the same way
///   none:      stores anyway; a later step that needs the value waits for the store
enum class Branches { predicted, none };

/// Chooses by the last steps of a loop: a branch pays if at most a tenth of them changed
/// something.
class BranchChoice {
 public:
    bool unpredictable() const { return unpredictable_; }
    void learn(std::size_t changes, std::size_t steps) {
        unpredictable_ = kPredictableOneIn * changes > steps;
    }

 private:
    /// A branch that goes the other way more often than once in so many steps costs more than
    /// the stores. Estimate.
    static constexpr std::size_t kPredictableOneIn = 10;

    bool unpredictable_ = true;
};

}  // namespace superray
