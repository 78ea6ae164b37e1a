// SPDX-License-Identifier: BSD-3-Clause
#pragma once
/// \file live_view.h
/// A window that shows map and trajectory while they grow.

#include <superray/slam/range_slam.h>

#include <memory>

namespace superray {

/// Needs a display (X11). The window may be closed at any time.
class LiveView {
 public:
    /// \throws InputError without a display
    LiveView();
    /// Waits until the window is gone; in vain, for some seconds, if it never appeared.
    ~LiveView();
    LiveView(const LiveView&) = delete;
    LiveView& operator=(const LiveView&) = delete;

    /// Shows what there is now; the map is drawn anew only if it changed.
    void show(const RangeSlam& slam);
    bool isOpen() const;

 private:
    struct Window;
    std::unique_ptr<Window> window_;
};

}  // namespace superray
