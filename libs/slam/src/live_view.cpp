#include <mrpt/gui/CDisplayWindow3D.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <superray/eval/input_error.h>
#include <superray/maps/mrpt_compat.h>
#include <superray/maps/super_ray_map_interface.h>
#include <superray/slam/live_view.h>
#include <superray/slam/slam_output.h>

#include <cstdlib>

namespace superray {

struct LiveView::Window {
    mrpt::gui::CDisplayWindow3D display{"superray-slam", 960, 720};
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
