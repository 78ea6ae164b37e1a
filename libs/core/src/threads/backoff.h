// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What repays in some scans of a sequence, but not in others.

namespace superray {

/// Whether to try it now: after a try in vain, not again before the tenth chance.
class Backoff {
 public:
    static constexpr int kChances = 10;  ///< from a try in vain to the next try

    bool tryNow() { return left_ == 0 || --left_ == 0; }
    void learn(bool repaid) { left_ = repaid ? 0 : kChances; }

 private:
    int left_ = 0;  // chances; 0: no need to wait
};

}  // namespace superray
