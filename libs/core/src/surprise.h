#pragma once
// Loops that may or may not change something at each step.

#include <cstddef>

namespace superray {

/// How to leave out what changes nothing: by a branch, which costs nothing where
/// nearly all steps go the same way, or not at all. A store that changes nothing
/// is not free: a step that needs the same value next waits for it.
enum class Branches { predicted, none };

/// Which of them is faster for the next steps, going by the last ones.
class Surprise {
 public:
    bool unpredictable() const { return unpredictable_; }
    void learn(std::size_t changes, std::size_t steps) {
        unpredictable_ = 10 * changes > steps;
    }

 private:
    bool unpredictable_ = true;
};

/// Whether to try something that repays in some scans of a sequence, but not in others:
/// after a try in vain, not in the next few.
class Attempts {
 public:
    bool tryNow() { return pause_ == 0 || --pause_ == 0; }
    void learn(bool repaid) { pause_ = repaid ? 0 : kPause; }

 private:
    static constexpr int kPause = 10;  ///< walks of scans, or parts of them
    int pause_ = 0;
};

/// Calls step(place, i) for i = 0 .. count - 1, in an order that takes neighbours from
/// four places in turn: where they often need the same value, none waits for the store
/// of the one before.
template <typename Step>
inline void inTurns(std::size_t count, const Step& step) {
    const std::size_t quarter = count / 4;
    for (std::size_t i = 0; i < quarter; ++i)
        for (std::size_t place = 0; place < 4; ++place) step(place, place * quarter + i);
    for (std::size_t i = 4 * quarter; i < count; ++i) step(std::size_t{3}, i);
}

}  // namespace superray
