// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/gui/CDisplayWindow3D.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <superray/eval/input_error.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/super_ray_map_interface.h>
#include <superray/slam/live_view.h>
#include <superray/slam/slam_output.h>

#include <chrono>
#include <cstdlib>
#include <thread>

namespace superray {

namespace {

/// Looks every 10 ms, for 5 s at most, which a window that is never painted would take.
template <class Condition>
void waitUntil(Condition&& condition) {
    for (int i = 0; i < 500 && !condition(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

/// MRPT destroys the window in a thread of its own, some time after it has told us so, and
/// may paint it until then: with the scene and the lock of the CDisplayWindow3D, which is
/// gone by then if the machine is busy. So the destructor here returns last. The canvas
/// shares the scene from its first painting until its end, which is how we see both.
class Display : public mrpt::gui::CDisplayWindow3D {
 public:
    Display() : CDisplayWindow3D("superray-slam", 960, 720) {}

    ~Display() override {
        waitUntil([this] { return !isOpen() || canvasHoldsScene(); });
        destroyWxWindow();
        // Painting lets the scene go for a moment before it takes it again.
        int goneInARow = 0;
        waitUntil([&] { return (goneInARow = canvasHoldsScene() ? 0 : goneInARow + 1) == 3; });
    }

 private:
    bool canvasHoldsScene() const { return m_3Dscene.use_count() > 1; }
};

}  // namespace

struct LiveView::Window {
    Display display;
    mrpt::opengl::CSetOfObjects::Ptr map;
    std::uint64_t shownStamp = 0;
};

LiveView::LiveView() {
    // MRPT would only write a message, and then wait for a window that never comes.
    const char* display = std::getenv("DISPLAY");
    if (!display || !*display)
        throw InputError("a live view needs a display; DISPLAY is not set");
    window_ = std::make_unique<Window>();
    window_->display.setCameraAzimuthDeg(-110);
    window_->display.setCameraElevationDeg(40);
    window_->display.setCameraZoom(30);
}

LiveView::~LiveView() = default;

bool LiveView::isOpen() const {
    return window_->display.isOpen();
}

void LiveView::show(const RangeSlam& slam) {
    if (!isOpen()) return;
    const auto stamp = dynamic_cast<const SuperRayMapInterface&>(slam.map()).changeStamp();
    if (!window_->map || window_->shownStamp != stamp) {
        window_->map = mrpt::opengl::CSetOfObjects::Create();
        slam.map().getVisualizationInto(*window_->map);
        window_->shownStamp = stamp;
    }
    auto& scene = window_->display.get3DSceneAndLock();
    scene->clear();
    scene->insert(window_->map);
    scene->insert(makeTrajectoryView(slam.trajectory()));
    window_->display.unlockAccess3DScene();
    const auto& last = slam.trajectory().poses().rbegin()->second;
    window_->display.setCameraPointingToPoint(static_cast<float>(last.x()),
                                              static_cast<float>(last.y()),
                                              static_cast<float>(last.z()));
    window_->display.repaint();
}

}  // namespace superray
