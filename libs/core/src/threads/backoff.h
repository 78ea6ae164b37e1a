// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Suspends an optimisation for some scans after it did not pay.

namespace superray {

/// Decides scan by scan whether to try an optimisation: as long as it pays, always; after a
/// try in vain, not before the tenth scan.
class Backoff {
 public:
    static constexpr int kChances = 10;  ///< scans from a try in vain to the next try

    bool tryNow() { return left_ == 0 || --left_ == 0; }
    void learn(bool repaid) { left_ = repaid ? 0 : kChances; }

 private:
    int left_ = 0;  // scans to wait; 0: none
};

}  // namespace superray
