// SPDX-License-Identifier: BSD-3-Clause
// Which poses of a recording are used: dirt that users' recordings have.

#include <gtest/gtest.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <superray/eval/input_error.h>

#include <filesystem>

#include "eval/sources/room_scans.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

constexpr int kScans = 6;

ScanSourceOptions withLabel(const std::string& label, PoseOrigin origin = PoseOrigin::input) {
    ScanSourceOptions options;
    options.poses = origin;
    options.poseLabel = label;
    return options;
}

mrpt::obs::CObservationOdometry::Ptr odometryAt(double seconds, const CPose2D& start = {},
                                                const std::string& label = "ODOMETRY") {
    auto odometry = makeOdometry(seconds, start + CPose2D(driveX(seconds), 0, 0));
    odometry->sensorLabel = label;
    return odometry;
}

mrpt::obs::CObservationRobotPose::Ptr poseAt(double seconds, const std::string& label,
                                             const CPose3D& start = {}) {
    auto pose = makePose(seconds, start + CPose3D(driveX(seconds), 0, 0, 0, 0, 0));
    pose->sensorLabel = label;
    return pose;
}

Objects drive(const CPose2D& start = {}) {
    Objects objects;
    for (int i = 0; i < kScans; ++i) {
        objects.push_back(odometryAt(i, start));
        objects.push_back(roomScan(i, driveX(i)));
    }
    return objects;
}

mrpt::obs::CSensoryFrame::Ptr frameOf(const Objects& observations) {
    auto frame = mrpt::obs::CSensoryFrame::Create();
    for (const auto& o : observations)
        frame->insert(std::dynamic_pointer_cast<mrpt::obs::CObservation>(o));
    return frame;
}

mrpt::obs::CActionCollection::Ptr actionOf(const CPose2D& increment) {
    mrpt::obs::CActionRobotMovement2D move;
    move.computeFromOdometry(increment, {});
    auto actions = mrpt::obs::CActionCollection::Create();
    actions->insert(move);
    return actions;
}

class RecordedPosesTest : public testing::Test {
 protected:
    std::string write(const Objects& objects) {
        return writeRawlog(folder_ / (std::to_string(++files_) + ".rawlog"), objects);
    }
    BuiltMap build(const Objects& objects, const ScanSourceOptions& options = {}) {
        return buildPlan(write(objects), options);
    }
    std::string errorOf(const Objects& objects, const ScanSourceOptions& options = {}) {
        const auto path = write(objects);
        return messageOf<InputError>([&] { buildPlan(path, options); });
    }
    std::string base() { return build(drive()).digest; }

    TempFolder folder_;
    int files_ = 0;
};

TEST_F(RecordedPosesTest, areToldInOneLine) {
    EXPECT_EQ(build(drive()).poses, "odometry 'ODOMETRY', 6, 0.0 to 5.0 s");
    expectPart(describe(build(drive()).report),
               "poses: odometry 'ODOMETRY', 6, 0.0 to 5.0 s\n");
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    EXPECT_EQ(build(drive(), fixed).poses, "the robot stays at the map's origin");
    EXPECT_EQ(build({actionOf({}), frameOf({roomScan(0, 0)}), actionOf({0.5, 0, 0}),
                     frameOf({roomScan(1, 0.5)})})
                  .poses.substr(0, 10),
              "actions, 2");
}

TEST_F(RecordedPosesTest, withoutTimesArePairedByOrder) {
    const auto expected = base();
    const auto odometryFirst = build(withoutTimes(drive()));
    EXPECT_EQ(odometryFirst.digest, expected);
    expectPart(odometryFirst.poses, "by their order");

    Objects scanFirst, frames, equalTimes = drive();
    for (int i = 0; i < kScans; ++i) {
        scanFirst.push_back(roomScan(i, driveX(i)));
        scanFirst.push_back(odometryAt(i));
        frames.push_back(frameOf(withoutTimes({roomScan(i, driveX(i)), odometryAt(i)})));
    }
    for (const auto& object : equalTimes)
        std::dynamic_pointer_cast<mrpt::obs::CObservation>(object)->timestamp = at(7);
    EXPECT_EQ(build(withoutTimes(scanFirst)).digest, expected);
    EXPECT_EQ(build(frames).digest, expected);
    EXPECT_EQ(build(equalTimes).digest, expected);

    // A coarse clock: two scans and two poses share each time stamp.
    Objects coarse = drive();
    for (std::size_t i = 0; i < coarse.size(); ++i)
        std::dynamic_pointer_cast<mrpt::obs::CObservation>(coarse[i])->timestamp =
            at(std::floor(static_cast<double>(i) / 4));
    EXPECT_EQ(build(coarse).digest, expected);
}

TEST_F(RecordedPosesTest, areRefusedWhereNeitherTimeNorOrderTells) {
    Objects scansAround = drive();
    scansAround.erase(scansAround.begin());  // begins and ends with a scan
    expectPart(errorOf(withoutTimes(scansAround)), "a scan comes first, and one last");
    Objects twoScansToOnePose = drive();
    twoScansToOnePose.erase(twoScansToOnePose.begin() + 4);
    expectPart(errorOf(withoutTimes(twoScansToOnePose)),
               "one sensor has several scans to one pose");
    // Two sensors may share a pose.
    Objects twoSensors;
    for (int i = 0; i < kScans; ++i) {
        twoSensors.push_back(odometryAt(i));
        twoSensors.push_back(roomScan(i, driveX(i)));
        twoSensors.push_back(roomScan(i, driveX(i), "REAR"));
    }
    const auto expected = build(twoSensors).digest;
    EXPECT_EQ(build(withoutTimes(twoSensors)).digest, expected);
}

TEST_F(RecordedPosesTest, oneScanWithoutATimeIsLeftOutAndCounted) {
    Objects objects = drive();
    std::dynamic_pointer_cast<mrpt::obs::CObservation>(objects[5])->timestamp = {};
    const auto built = build(objects);
    EXPECT_EQ(built.report.scans, 5u);
    EXPECT_EQ(built.report.skipped.withoutTime, 1u);
    expectPart(describe(built.report), "scans without a time stamp             1");
}

TEST_F(RecordedPosesTest, actionsThatTellNothingLeaveItToTheOdometry) {
    const auto expected = base();
    Objects empty, atRest, noPoses;
    for (int i = 0; i < kScans; ++i) {
        const auto frame = frameOf({odometryAt(i), roomScan(i, driveX(i))});
        empty.insert(empty.end(), {mrpt::obs::CActionCollection::Create(), frame});
        atRest.insert(atRest.end(), {actionOf({}), frame});
        noPoses.insert(noPoses.end(), {mrpt::obs::CActionCollection::Create(),
                                       frameOf({roomScan(i, driveX(i))})});
    }
    EXPECT_EQ(build(empty).digest, expected);
    EXPECT_EQ(build(atRest).digest, expected);
    expectPart(errorOf(noPoses), "holds no robot poses");
    // Asked for, the actions that say that the robot stood are taken at their word.
    const auto stood = build(atRest, withLabel("", PoseOrigin::actions));
    EXPECT_NE(stood.digest, expected);
    EXPECT_EQ(stood.poses.substr(0, 10), "actions, 6");
}

TEST_F(RecordedPosesTest, ofTwoLabelsAreRefusedWithTheList) {
    const auto expected = base();
    Objects robotPoses, odometries, both;
    for (int i = 0; i < kScans; ++i) {
        const auto scan = roomScan(i, driveX(i));
        const auto good = poseAt(i, "amcl"),
                   far = poseAt(i + 0.3, "gps", CPose3D(100, 50, 0, 1, 0, 0));
        robotPoses.insert(robotPoses.end(), {good, scan, far});
        odometries.insert(odometries.end(), {odometryAt(i, {}, "wheels"), scan,
                                             odometryAt(i + 0.3, CPose2D(-7, 0, 2), "visual")});
        both.insert(both.end(), {far, good, odometryAt(i), scan});
    }
    expectPart(errorOf(robotPoses), "robot poses of 2 labels, 'amcl' (6), 'gps' (6)");
    EXPECT_EQ(build(robotPoses, withLabel("amcl")).digest, expected);
    EXPECT_EQ(build(robotPoses, withLabel("amcl")).poses,
              "robot poses 'amcl', 6, 0.0 to 5.0 s");
    expectPart(errorOf(odometries), "odometry of 2 labels, 'visual' (6), 'wheels' (6)");
    EXPECT_EQ(build(odometries, withLabel("wheels")).digest, expected);
    expectPart(errorOf(both), "'amcl' (6), 'gps' (6)");
    EXPECT_EQ(build(both, withLabel("", PoseOrigin::odometry)).digest, expected);
    EXPECT_EQ(build(both, withLabel("ODOMETRY")).digest, expected);
    const auto unknown = errorOf(both, withLabel("slam"));
    expectPart(unknown, "no poses with the label 'slam'");
    expectPart(unknown, "it has: robot poses 'amcl' (6), 'gps' (6); odometry 'ODOMETRY' (6)");
}

TEST_F(RecordedPosesTest, areNotInventedInGaps) {
    // Robot poses, odometry, and a poses file; a scan in the middle of a minute without.
    Objects robotPoses, odometries, scansOnly;
    std::string tum;
    for (const int i : {0, 1, 2, 62}) {
        robotPoses.insert(robotPoses.end(), {poseAt(i, "amcl"), roomScan(i, 1)});
        odometries.insert(odometries.end(), {odometryAt(i), roomScan(i, 1)});
        scansOnly.push_back(roomScan(i, 1));
        tum += std::to_string(i) + " " + std::to_string(driveX(i)) + " 0 0 0 0 0 1\n";
    }
    for (Objects* objects : {&robotPoses, &odometries, &scansOnly})
        objects->push_back(roomScan(30, 1));
    ScanSourceOptions fromFile;
    fromFile.poses = PoseOrigin::file;
    fromFile.posesFile = folder_.write("a.tum", tum);
    const auto expectLeftOut = [&](const Objects& objects, ScanSourceOptions options) {
        const auto built = build(objects, options);
        EXPECT_EQ(built.report.scans, 4u);
        EXPECT_EQ(built.report.skipped.inPoseGap, 1u);
        EXPECT_EQ(built.report.skipped.withoutPose, 0u);
        expectPart(describe(built.report), "scans in a gap between two poses       1");
        options.maxPoseGap = 60;
        EXPECT_EQ(build(objects, options).report.scans, 5u);
        options.maxPoseGap = 59.9;
        EXPECT_EQ(build(objects, options).report.scans, 4u);
    };
    expectLeftOut(robotPoses, {});
    expectLeftOut(odometries, {});
    expectLeftOut(scansOnly, fromFile);
    expectPart(errorOf({poseAt(0, "amcl"), poseAt(62, "amcl"), roomScan(30, 1)}),
               "gaps of more than 2 s are not bridged (--max-pose-gap)");
    // Just beside a pose the robot is still there.
    const auto beside = build({poseAt(0, "a"), roomScan(0.04, 0), poseAt(62, "a")});
    EXPECT_EQ(beside.report.scans, 1u);
}

TEST_F(RecordedPosesTest, thatAreFewFixTheOdometryToTheMap) {
    // The odometry begins anywhere; the start pose says where.
    const CPose2D anywhere(-3, 7, 2.5);
    Objects start = drive(anywhere), late = drive(anywhere);
    start.insert(start.begin(), poseAt(0, "initialpose"));
    late.push_back(poseAt(4, "localisation"));
    const auto fixedAtStart = build(start);
    EXPECT_EQ(fixedAtStart.report.scans, 6u);
    EXPECT_EQ(fixedAtStart.poses,
              "odometry 'ODOMETRY', 6, 0.0 to 5.0 s, fixed to the map by robot poses "
              "'initialpose', 1");
    EXPECT_EQ(build(late).report.scans, 6u);
    const auto posesOf = [&](const Objects& objects) {
        std::vector<CPose3D> poses;
        const auto source = openScanSource(write(objects));
        while (const auto scan = source->next()) poses.push_back(scan->T_map_robot);
        return poses;
    };
    for (const Objects& objects : {start, late, withoutTimes(start)}) {
        const auto poses = posesOf(objects);
        ASSERT_EQ(poses.size(), 6u);
        for (int i = 0; i < kScans; ++i) {
            const auto& pose = poses[static_cast<std::size_t>(i)];
            EXPECT_NEAR(pose.x(), driveX(i), 1e-9);
            EXPECT_NEAR(pose.y(), 0, 1e-9);
            EXPECT_NEAR(pose.yaw(), 0, 1e-9);
        }
    }
}

TEST_F(RecordedPosesTest, spreadTheDriftBetweenTwoOfThem) {
    // Over 5 s the odometry says 3 m where two poses say 2.5 m.
    Objects objects = {poseAt(0, "gps")};
    for (int i = 0; i < kScans; ++i) {
        objects.push_back(makeOdometry(i, CPose2D(0.6 * i, 0, 0)));
        objects.push_back(roomScan(i, driveX(i)));
    }
    objects.push_back(poseAt(5, "gps"));
    const auto source = openScanSource(write(objects));
    int i = 0;
    for (; const auto scan = source->next(); ++i)
        EXPECT_NEAR(scan->T_map_robot.x(), driveX(i), 1e-6) << i;
    EXPECT_EQ(i, kScans);
    // Each source alone, if asked for.
    EXPECT_EQ(build(objects, withLabel("gps")).report.scans, 2u);
    EXPECT_EQ(build(objects, withLabel("", PoseOrigin::robotPoses)).report.scans, 2u);
    EXPECT_EQ(build(objects, withLabel("ODOMETRY")).poses,
              "odometry 'ODOMETRY', 6, 0.0 to 5.0 s");
}

TEST_F(RecordedPosesTest, fixActionsToo) {
    const auto moved = [](double x) {
        Objects objects = {poseAt(0, "initialpose", CPose3D(x, 0, 0, 0, 0, 0))};
        for (int i = 0; i < kScans; ++i) {
            objects.push_back(actionOf(i == 0 ? CPose2D() : CPose2D(0.5, 0, 0)));
            objects.push_back(frameOf({roomScan(i, driveX(i))}));
        }
        return objects;
    };
    const auto built = build(moved(0));
    EXPECT_EQ(built.report.scans, 6u);
    EXPECT_EQ(built.digest, base());
    expectPart(built.poses, "fixed to the map by robot poses 'initialpose', 1");
    EXPECT_NE(build(moved(2)).digest, base());
}

TEST_F(RecordedPosesTest, ofActionsHoldAsLongAsPosesAreBridged) {
    Objects objects;
    for (int i = 0; i < 3; ++i) {
        auto action = actionOf(i == 0 ? CPose2D() : CPose2D(0.5, 0, 0));
        (*action->begin())->timestamp = at(i);
        objects.push_back(action);
        objects.push_back(frameOf({roomScan(i + 0.1, driveX(i))}));
    }
    EXPECT_EQ(build(objects).report.scans, 3u);
    // The robot may be anywhere by then.
    for (int i = 3; i < 9; ++i) objects.push_back(roomScan(i, driveX(i)));
    const auto built = build(objects);
    EXPECT_EQ(built.report.scans, 5u) << "those until 2 s after the last action";
    EXPECT_EQ(built.report.skipped.withoutPose, 4u);
    ScanSourceOptions patient;
    patient.maxPoseGap = 100;
    EXPECT_EQ(build(objects, patient).report.scans, 9u);
}

TEST_F(RecordedPosesTest, ofOneTimeMustAgree) {
    const auto withSecond = [&](PoseOrigin kind, double seconds, double metres) {
        const bool robotPoses = kind == PoseOrigin::robotPoses;
        Objects objects;
        for (int i = 0; i < kScans; ++i) {
            if (robotPoses)
                objects.push_back(poseAt(i, "GT"));
            else
                objects.push_back(odometryAt(i));
            objects.push_back(roomScan(i + 0.5, driveX(i + 0.5)));
        }
        if (robotPoses)
            objects.push_back(poseAt(seconds, "GT", CPose3D(metres, 0, 0, 0, 0, 0)));
        else
            objects.push_back(odometryAt(seconds, CPose2D(metres, 0, 0)));
        return errorOf(objects);
    };
    for (const auto kind : {PoseOrigin::robotPoses, PoseOrigin::odometry}) {
        for (const double seconds : {0.0, 3.0, 5.0}) {
            expectPart(withSecond(kind, seconds, 50), "contradict each other: they are 50 m");
            EXPECT_EQ(withSecond(kind, seconds, 0), "no exception");
            // A clock has ticks: within one the robot moves on.
            EXPECT_EQ(withSecond(kind, seconds, 0.09), "no exception");
        }
        EXPECT_EQ(withSecond(kind, 3, 0.5), "no exception") << "it moves 1 m around it";
    }
    // Each pose twice.
    Objects doubled = drive();
    for (int i = 0; i < kScans; ++i) doubled.push_back(odometryAt(i, CPose2D(50, 0, 0)));
    expectPart(errorOf(doubled), "contradict each other");
    // Two anchors of an odometry.
    Objects anchored = drive();
    anchored.push_back(poseAt(2, "GT", CPose3D(100, 0, 0, 0, 0, 0)));
    EXPECT_EQ(errorOf(anchored), "no exception");
    anchored.push_back(poseAt(2, "GT", CPose3D(-100, 0, 0, 0, 0, 0)));
    expectPart(errorOf(anchored), "robot poses 'GT': two poses of the time");
}

TEST_F(RecordedPosesTest, thatAreNotFiniteAreSkippedAndCounted) {
    const auto expected = build(
        {poseAt(0, "p"), roomScan(0, 0), roomScan(1, 0.5), poseAt(2, "p"), roomScan(2, 1)});
    auto broken = poseAt(1, "p");
    broken->pose.mean.x(std::nan(""));
    const auto built = build({poseAt(0, "p"), roomScan(0, 0), broken, roomScan(1, 0.5),
                              poseAt(2, "p"), roomScan(2, 1)});
    EXPECT_EQ(built.digest, expected.digest);
    EXPECT_EQ(built.report.skipped.badPoses, 1u);
    expectPart(describe(built.report), "poses not finite                       1");
    expectPart(errorOf({actionOf({std::nan(""), 0, 0}), frameOf({roomScan(0, 0)})}),
               "movement of action 1 is not finite");
}

TEST(RecordingCases, poseCasesAreMappedAsTheyShould) {
    if (!std::filesystem::exists(casePath("base_odo.rawlog")))
        GTEST_SKIP() << "CASES ABSENT: " << casePath("") << "; NOT TESTED";
    const auto expected = buildPlan(casePath("base_odo.rawlog"));
    EXPECT_EQ(expected.poses, "odometry 'ODOMETRY', 6, 0.0 to 5.0 s");
    const auto digestOf = [](const std::string& name, UpdatePolicy policy) {
        ScanSources sources;
        sources.push_back(openScanSource(casePath(name + ".rawlog")));
        CSuperRayGridMap2D map(0.1);
        map.insertionOptions.setPolicy(policy);
        buildMap(sources, map, std::numeric_limits<std::uint64_t>::max(),
                 [](const BuildProgress&) {});
        return map.digest();
    };
    for (const auto policy :
         {UpdatePolicy::everyRay, UpdatePolicy::oncePerScan, UpdatePolicy::netEvidence})
        for (const char* name : {"invalid_stamps", "empty_actions", "one_pose"})
            EXPECT_EQ(digestOf(name, policy), digestOf("base_odo", policy)) << name;

    const auto message = messageOf<InputError>([] { buildPlan(casePath("two_poses.rawlog")); });
    expectPart(message, "'amcl' (6), 'gps_utm' (6)");
    const auto source = openScanSource(casePath("two_poses.rawlog"), withLabel("amcl"));
    for (int i = 0; i < kScans; ++i) {
        const auto scan = source->next();
        ASSERT_TRUE(scan);
        EXPECT_NEAR(scan->T_map_robot.x(), 0.5 * i, 0.01);  // scans are 10 ms after poses
        EXPECT_EQ(scan->T_map_robot.y(), 0);
    }
    EXPECT_FALSE(source->next());

    const auto gap = buildPlan(casePath("gap.rawlog"));
    EXPECT_EQ(gap.report.scans, 3u);
    EXPECT_EQ(gap.report.skipped.inPoseGap, 1u);
}

}  // namespace
}  // namespace superray
