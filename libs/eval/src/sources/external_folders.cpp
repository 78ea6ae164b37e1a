// SPDX-License-Identifier: BSD-3-Clause
#include "sources/external_folders.h"

#include <mrpt/img/CImage.h>
#include <mrpt/io/lazy_load_path.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>

#include <algorithm>
#include <system_error>

namespace superray {

namespace fs = std::filesystem;

std::vector<std::string> externalFilesOf(const mrpt::obs::CObservation& observation) {
    using mrpt::obs::CObservation3DRangeScan;
    using mrpt::obs::CObservationPointCloud;
    std::vector<std::string> files;
    if (const auto* camera = dynamic_cast<const CObservation3DRangeScan*>(&observation)) {
        // Colours are not needed.
        if (camera->hasRangeImage && camera->rangeImage_isExternallyStored())
            files.push_back(camera->rangeImage_getExternalStorageFile(""));
        if (camera->hasPoints3D && camera->points3D_isExternallyStored())
            files.push_back(camera->points3D_getExternalStorageFile());
    } else if (const auto* cloud = dynamic_cast<const CObservationPointCloud*>(&observation)) {
        if (cloud->isExternallyStored()) files.push_back(cloud->getExternalStorageFile());
    }
    return files;
}

ExternalFolders::ExternalFolders(const std::string& recording) {
    fs::path stem = fs::absolute(recording);
    const fs::path beside = stem.parent_path();
    for (const char* extension : {".gz", ".rawlog"})
        if (equalIgnoringCase(stem.extension().string(), extension)) stem.replace_extension();
    const std::string own = stem.filename().string() + "_Images";
    // The usual name first, then the other cases of letters in a fixed order.
    std::vector<fs::path> ofThisName, common;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(beside, error)) {
        if (!entry.is_directory(error)) continue;
        const std::string name = entry.path().filename().string();
        if (equalIgnoringCase(name, own)) ofThisName.push_back(entry.path());
        if (equalIgnoringCase(name, "Images")) common.push_back(entry.path());
    }
    const auto usualFirst = [](const fs::path& a, const fs::path& b) {
        const auto isUsual = [](const fs::path& p) {
            const std::string name = p.filename().string();
            return name.size() >= 6 && name.compare(name.size() - 6, 6, "Images") == 0;
        };
        return isUsual(a) != isUsual(b) ? isUsual(a) : a < b;
    };
    std::sort(ofThisName.begin(), ofThisName.end(), usualFirst);
    std::sort(common.begin(), common.end(), usualFirst);
    if (ofThisName.empty()) ofThisName.push_back(beside / own);
    folders_ = ofThisName;
    folders_.insert(folders_.end(), common.begin(), common.end());
    folders_.push_back(beside);
}

std::string ExternalFolders::find(const std::string& file) const {
    std::error_code error;
    for (const auto& folder : folders_)
        if (fs::exists(folder / file, error)) return folder.string();
    return {};
}

void ExternalFolders::useFor(const mrpt::obs::CObservation& observation) const {
    for (const std::string& file : externalFilesOf(observation)) {
        const std::string folder = find(file);
        if (folder.empty()) {
            std::string tried;
            for (const auto& f : folders_) tried += (tried.empty() ? "" : ", ") + f.string();
            throw InputError("its external file " + file + " is not there; looked in " + tried);
        }
        mrpt::io::setLazyLoadPathBase(folder);
        mrpt::img::CImage::setImagesPathBase(folder);
    }
}

}  // namespace superray
