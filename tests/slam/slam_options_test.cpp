// SPDX-License-Identifier: BSD-3-Clause
// Options of SLAM: strict reading, and the configuration files that we ship.

#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/slam/slam_options.h>

#include <filesystem>

#include "eval/temp_folder.h"

namespace superray {
namespace {

const std::string kFolder = SUPERRAY_CONFIG_FILES_DIR "/";

std::string errorOf(const std::string& ini) {
    const test::TempFolder folder;
    TSlamOptions options;
    const std::string before = options.toText();
    const auto message = test::messageOf<std::invalid_argument>(
        [&] { options.loadFromFile(folder.write("a.ini", ini)); });
    EXPECT_EQ(options.toText(), before) << "nothing changes on an error";
    return message;
}

TEST(SlamOptions, TextReadsBack) {
    TSlamOptions options;
    options.registration.resolutions = "2, 0.7,0.1";
    options.registration.yawSearch = 12.5;
    options.registration.icp = false;
    options.keyFrames.prior = MotionPrior::odometry;
    options.keyFrames.insertionLinDistance = 0.123;
    options.icp.thresholdDist = 0.77;
    const test::TempFolder folder;
    TSlamOptions read;
    read.loadFromFile(folder.write("a.ini", options.toText()));
    EXPECT_EQ(read.toText(), options.toText());
    EXPECT_EQ(read.registration.levels(), (std::vector<double>{2, 0.7, 0.1}));
    EXPECT_EQ(read.keyFrames.prior, MotionPrior::odometry);
    EXPECT_NEAR(read.icp.thresholdDist, 0.77, 1e-6);  // MRPT reads floats
}

TEST(SlamOptions, MistakesAreNamed) {
    const struct {
        const char *ini, *part;
    } mistakes[] = {
        {"[registration]\nmaxRangge = 3\n", "did you mean maxRange"},
        {"[registration]\nresolutions = 0.5, 1\n", "each smaller than the one before"},
        {"[registration]\nresolutions = a\n", "resolutions = a"},
        {"[registration]\npointSpacing = 0\n", "pointSpacing > 0"},
        {"[registration]\nminPlanarity = 1.5\n", "0 <= minPlanarity <= 1"},
        {"[registration]\nsmallestGate = 3\n", "smallestGate <= gate"},
        {"[registration]\nicp = false\nrefinementSteps = 0\n", "refinementSteps > 0"},
        {"[registration]\nyawSearch = 200\n", "yawSearch <= 180"},
        {"[registration]\nmaxRange = -1\n", "maxRange > minRange"},
        {"[keyframes]\nprior = magic\n", "constantVelocity, odometry, none"},
        {"[keyframes]\ninsertionLinDistance = -1\n", "insertionLinDistance >= 0"},
        {"[keyframes]\nminICPgoodness = 2\n", "minICPgoodness <= 1"},
        {"[icp]\nALFA = 1\n", "ALFA < 1"},
        {"[icp]\nmaxIteration = 1\n", "did you mean maxIterations"},
        {"[other]\na = 1\n", "none of the sections"},
    };
    for (const auto& m : mistakes)
        EXPECT_NE(errorOf(m.ini).find(m.part), std::string::npos)
            << m.ini << " -> " << errorOf(m.ini);
    TSlamOptions options;
    EXPECT_THROW(options.loadFromFile("/nonexistent.ini"), InputError);
}

TEST(SlamOptions, ShippedFilesAreValid) {
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
        const std::string name = entry.path().filename();
        if (name.rfind("superray-slam-", 0) != 0) continue;
        ++files;
        TSlamOptions options;
        EXPECT_NO_THROW(options.loadFromFile(entry.path())) << name;
    }
    EXPECT_EQ(files, 4);
}

TEST(SlamOptions, TheAdvancedFileHasEveryOptionWithItsDefault) {
    TSlamOptions read;
    read.registration.decimation = 77;  // must come from the file
    read.registration.resolutions = "9";
    read.registration.yawStep = 9;
    read.keyFrames.insertionAngDistance = 77;
    read.loadFromFile(kFolder + "superray-slam-advanced.ini");
    EXPECT_EQ(read.toText(), TSlamOptions().toText());
    const std::string text = test::readWholeFile(kFolder + "superray-slam-advanced.ini");
    for (const char* key : {"resolutions", "decimation", "minRange", "maxRange", "pointSpacing",
                            "rangeNoiseExponent", "minPlanarity", "icp", "refinementSteps",
                            "gate", "smallestGate", "yawSearch", "yawStep", "prior",
                            "insertionLinDistance", "insertionAngDistance", "minICPgoodness"})
        EXPECT_NE(text.find(std::string("\n") + key + " = "), std::string::npos) << key;
}

}  // namespace
}  // namespace superray
