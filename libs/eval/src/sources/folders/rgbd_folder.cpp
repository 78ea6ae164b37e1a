// SPDX-License-Identifier: BSD-3-Clause
// Folders of depth images: the TUM RGB-D benchmark and ICL-NUIM. The robot is the camera
// with x forward, y left and z up; the map is that of the ground truth.

#include <mrpt/obs/CObservation3DRangeScan.h>
#include <superray/eval/input_error.h>

#include <sstream>

#include "sources/folders/depth_image.h"
#include "sources/folders/frame_source.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

namespace fs = std::filesystem;
using mrpt::poses::CPose3D;

/// Ground truth is of the optical frame: z forward, x right, y down.
CPose3D opticalFrame() {
    return CPose3D(0, 0, 0, -M_PI / 2, 0, -M_PI / 2);
}

/// Rows of a time (or number) and a file, the first pair of a row that names depth.
void readList(const fs::path& folder, const fs::path& list, FrameRecording& recording) {
    recording.isTimed = false;
    forEachLine(list, [&](const std::string& line, const std::string& where) {
        std::istringstream row(line);
        std::string stamp, file, found, foundStamp;
        while (found.empty() && row >> stamp >> file)
            if (file.find("depth") != std::string::npos) {
                found = file;
                foundStamp = stamp;
            }
        const auto time = timeOfName(foundStamp);
        if (found.empty() || !time)
            throw InputError(where + ": must be rows of a time and a file in depth/");
        Frame frame;
        frame.file = folder / found;
        frame.time = *time;
        frame.row = frameNumber(foundStamp);
        recording.isTimed = recording.isTimed || !frame.row;
        recording.frames.push_back(frame);
    });
}

void listDepth(const fs::path& folder, FrameRecording& recording) {
    for (const char* name : {"associations.txt", "associated.txt", "depth.txt"})
        if (fs::exists(folder / name)) return readList(folder, folder / name, recording);
    addNamedFrames(listFrames(folder / "depth", {".png"}), recording);
}

/// groundtruth.txt, or ICL-NUIM's *.gt.freiburg.
fs::path findGroundTruth(const fs::path& folder) {
    if (fs::exists(folder / "groundtruth.txt")) return folder / "groundtruth.txt";
    for (const auto& file : listFrames(folder, {".freiburg"})) return file;
    throw InputError(folder.string() +
                     ": has neither groundtruth.txt nor *.gt.freiburg; give a poses file "
                     "(--poses FILE)");
}

/// All images of a folder are of one camera, whose intrinsics are for one size.
class ImageSize {
 public:
    explicit ImageSize(const DepthCamera& camera) : isDefault_(camera.hasDefaultIntrinsics()) {}

    /// \throws InputError naming the image and both sizes
    void require(const std::string& file, std::uint32_t columns, std::uint32_t rows) {
        const std::string size = std::to_string(columns) + " x " + std::to_string(rows);
        if (isDefault_ &&
            (columns != DepthCamera::kDefaultColumns || rows != DepthCamera::kDefaultRows))
            throw InputError(file + ": is an image of " + size +
                             ", but the camera that is taken where none is given is one of "
                             "640 x 480; give its camera (--intrinsics)");
        if (size_.empty()) size_ = size;
        if (size != size_)
            throw InputError(file + ": is an image of " + size + ", the first one is " + size_ +
                             "; one camera has images of one size");
    }

 private:
    bool isDefault_;
    std::string size_;  ///< of the first image
};

mrpt::obs::CObservation::Ptr readImage(const Frame& frame, const DepthCamera& camera,
                                       ImageSize& size) {
    auto scan = mrpt::obs::CObservation3DRangeScan::Create();
    const auto image = readDepthPng(frame.file.string());
    size.require(frame.file.string(), static_cast<std::uint32_t>(image.cols()),
                 static_cast<std::uint32_t>(image.rows()));
    scan->hasRangeImage = true;
    scan->range_is_depth = true;
    scan->rangeUnits = static_cast<float>(1 / camera.unitsPerMetre);
    scan->maxRange = 0;  // not known
    scan->cameraParams.ncols = static_cast<std::uint32_t>(image.cols());
    scan->cameraParams.nrows = static_cast<std::uint32_t>(image.rows());
    scan->cameraParams.setIntrinsicParamsFromValues(camera.fx, camera.fy, camera.cx, camera.cy);
    scan->rangeImage = image;
    return scan;
}

}  // namespace

std::unique_ptr<ScanSource> openRgbd(const fs::path& folder, const ScanSourceOptions& asked) {
    if (!(asked.depthCamera.fx > 0 && asked.depthCamera.fy > 0 &&
          asked.depthCamera.unitsPerMetre > 0))
        throw InputError("the focal lengths and the depth units of the camera must be > 0");
    FrameRecording recording;
    recording.path = folder.string();
    recording.label = "DEPTH";
    listDepth(folder, recording);
    refuseTwins(recording);
    if (recording.frames.empty()) throwNoScans(folder.string(), asked, {});
    ScanSourceOptions options = asked;
    if (options.poses == PoseOrigin::input) {
        options.poses = PoseOrigin::file;
        options.posesFile = findGroundTruth(folder).string();
    }
    recording.guarded = true;  // libpng
    const bool ofCamera = options.poses == PoseOrigin::file;
    recording.read = [camera = asked.depthCamera, ofCamera,
                      size = ImageSize(asked.depthCamera)](const Frame& frame) mutable {
        auto scan = readImage(frame, camera, size);
        // Robot poses of the file are those of the optical frame.
        if (ofCamera) scan->setSensorPose(-opticalFrame());
        return scan;
    };
    return makeFrameSource(std::move(recording), options);
}

}  // namespace superray
