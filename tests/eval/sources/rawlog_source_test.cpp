// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <superray/eval/input_error.h>
#include <superray/eval/scan_source.h>
#include <superray/eval/trajectory.h>

#include "eval/recorded_scans.h"
#include "eval/sources/pose_matchers.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

std::vector<Scan> readAll(ScanSource& source) {
    std::vector<Scan> scans;
    while (auto scan = source.next()) scans.push_back(*scan);
    EXPECT_EQ(scans.size(), source.total());
    EXPECT_FALSE(source.next());
    return scans;
}

std::vector<Scan> readAll(const std::string& path, const ScanSourceOptions& options = {}) {
    return readAll(*openScanSource(path, options));
}

std::string errorOf(const std::string& path, const ScanSourceOptions& options = {}) {
    return messageOf<InputError>([&] { openScanSource(path, options); });
}

CPose3D poseNumber(int i) {
    return CPose3D(i, 0.5 * i, -0.25 * i, 0.1 * i, 0.02, -0.03 * i);
}

/// `count` scans, one a second, each after the robot pose of its time.
Objects posedScans(int count) {
    Objects objects;
    for (int i = 0; i < count; ++i) {
        objects.push_back(makePose(100 + i, poseNumber(i)));
        objects.push_back(makeCloud(100 + i, static_cast<unsigned>(i)));
    }
    return objects;
}

TEST(RawlogSource, givesScansWithTheirPosesAndPointsUnchanged) {
    TempFolder folder;
    for (const bool compressed : {true, false}) {
        const auto path = folder / (compressed ? "a.rawlog" : "b.rawlog");
        if (compressed)
            writeRawlog(path, posedScans(5));
        else
            writeRawlog<mrpt::io::CFileOutputStream>(path, posedScans(5));
        const auto scans = readAll(path);
        ASSERT_EQ(scans.size(), 5u);
        for (int i = 0; i < 5; ++i) {
            const auto& scan = scans[static_cast<std::size_t>(i)];
            const auto expected = makeCloud(100 + i, static_cast<unsigned>(i));
            EXPECT_EQ(scan.timestamp, at(100 + i));
            expectPoseNear(scan.T_map_robot, poseNumber(i), 1e-14);
            EXPECT_EQ(scan.observation->sensorLabel, "LIDAR");
            EXPECT_EQ(pointsOf(*scan.observation), pointsOf(*expected));
            CPose3D sensorPose;
            scan.observation->getSensorPose(sensorPose);
            expectPoseNear(sensorPose, expected->sensorPose, 1e-12);
        }
    }
}

TEST(RawlogSource, readsAFileThatIsOneRawlogObject) {
    TempFolder folder;
    auto rawlog = mrpt::obs::CRawlog::Create();
    for (const auto& object : posedScans(4)) rawlog->insert(object);
    const auto scans = readAll(writeRawlog(folder / "a.rawlog", {rawlog}));
    ASSERT_EQ(scans.size(), 4u);
    expectPoseNear(scans[3].T_map_robot, poseNumber(3));
}

TEST(RawlogSource, interpolatesPosesWhateverTheirPlaceInTheFile) {
    TempFolder folder;
    const auto scans = readAll(writeRawlog(
        folder / "a.rawlog", {makeCloud(10.25, 1), makePose(11, CPose3D(4, 0, 0, 0, 0, 0)),
                              makeCloud(10.5, 2), makePose(10, CPose3D(0, 0, 0, 0, 0, 0))}));
    ASSERT_EQ(scans.size(), 2u);
    expectPoseNear(scans[0].T_map_robot, CPose3D(1, 0, 0, 0, 0, 0));
    expectPoseNear(scans[1].T_map_robot, CPose3D(2, 0, 0, 0, 0, 0));
}

TEST(RawlogSource, usesOdometryOnlyWhereThereIsNoRobotPose) {
    TempFolder folder;
    Objects objects = {makeOdometry(10, CPose2D(1, 2, 0.5)), makeCloud(10, 1)};
    auto scans = readAll(writeRawlog(folder / "a.rawlog", objects));
    ASSERT_EQ(scans.size(), 1u);
    expectPoseNear(scans[0].T_map_robot, CPose3D(1, 2, 0, 0.5, 0, 0));

    objects.push_back(makePose(10, CPose3D(7, 8, 9, 0, 0, 0)));
    scans = readAll(writeRawlog(folder / "b.rawlog", objects));
    ASSERT_EQ(scans.size(), 1u);
    expectPoseNear(scans[0].T_map_robot, CPose3D(7, 8, 9, 0, 0, 0));
}

TEST(RawlogSource, sumsTheActionsOfActionObservationPairs) {
    TempFolder folder;
    mrpt::obs::CActionRobotMovement2D move2D;
    move2D.computeFromOdometry(CPose2D(1, 0, M_PI / 2), {});
    mrpt::obs::CActionRobotMovement3D move3D;
    move3D.poseChange.mean = CPose3D(0, 0, 2, 0, 0, 0);
    auto actions2D = mrpt::obs::CActionCollection::Create();
    actions2D->insert(move2D);
    auto actions3D = mrpt::obs::CActionCollection::Create();
    actions3D->insert(move3D);
    const auto frame = [](std::initializer_list<mrpt::obs::CObservation::Ptr> observations) {
        auto f = mrpt::obs::CSensoryFrame::Create();
        for (const auto& o : observations) f->insert(o);
        return f;
    };
    const auto scans = readAll(writeRawlog(
        folder / "a.rawlog", {mrpt::obs::CActionCollection::Create(), frame({makeCloud(1, 1)}),
                              actions2D, frame({makeCloud(2, 2), makeCloud(2, 3)}), actions2D,
                              actions3D, frame({makeCloud(3, 4)})}));
    ASSERT_EQ(scans.size(), 4u);
    expectPoseNear(scans[0].T_map_robot, CPose3D());
    expectPoseNear(scans[1].T_map_robot, CPose3D(1, 0, 0, M_PI / 2, 0, 0));
    expectPoseNear(scans[2].T_map_robot, CPose3D(1, 0, 0, M_PI / 2, 0, 0));
    expectPoseNear(scans[3].T_map_robot, CPose3D(1, 1, 2, M_PI, 0, 0));
    EXPECT_EQ(pointsOf(*scans[2].observation), pointsOf(*makeCloud(2, 3)));
}

TEST(RawlogSource, keepsOnlyTheWantedLabel) {
    TempFolder folder;
    const auto path =
        writeRawlog(folder / "a.rawlog", {makePose(1, CPose3D()), makeCloud(1, 1, "FRONT"),
                                          makeCloud(1, 2, "REAR"), makeCloud(1, 3, "FRONT")});
    ScanSourceOptions options;
    options.sensorLabel = "FRONT";
    const auto source = openScanSource(path, options);
    EXPECT_EQ(readAll(*source).size(), 2u);
    EXPECT_EQ(source->skipped().otherLabel, 1u);
    options.sensorLabel = "TOP";
    EXPECT_NE(errorOf(path, options).find("none of its 3 scans has the sensor label 'TOP'"),
              std::string::npos)
        << errorOf(path, options);
}

TEST(RawlogSource, stopsAfterMaxScansWithTheSamePoses) {
    TempFolder folder;
    Objects objects;
    for (int i = 0; i < 10; ++i) {
        objects.push_back(makeCloud(100.5 + i, static_cast<unsigned>(i)));
        objects.push_back(makePose(100 + i, poseNumber(i)));
    }
    const auto path = writeRawlog(folder / "a.rawlog", objects);
    const auto all = readAll(path);
    EXPECT_EQ(all.size(), 9u);  // the last scan is half a second after the last pose
    for (std::size_t limit = 1; limit <= 9; ++limit) {
        ScanSourceOptions options;
        options.maxScans = limit;
        const auto some = readAll(path, options);
        ASSERT_EQ(some.size(), limit);
        for (std::size_t i = 0; i < limit; ++i)
            EXPECT_EQ(some[i].T_map_robot.asTPose(), all[i].T_map_robot.asTPose());
    }
    ScanSourceOptions options;
    options.maxScans = 0;
    EXPECT_NE(errorOf(path, options).find("at least 1"), std::string::npos);
}

TEST(RawlogSource, takesPosesFromAFileOrAFixedRobot) {
    TempFolder folder;
    const auto path = writeRawlog(folder / "a.rawlog",
                                  {makeCloud(10, 1), makeCloud(11, 2), makeCloud(12.5, 3)});
    ScanSourceOptions options;
    options.poses = PoseOrigin::file;
    options.posesFile = folder.write("a.tum", "10 1 2 3 0 0 0 1\n12 3 2 3 0 0 0 1\n");
    const auto source = openScanSource(path, options);
    const auto scans = readAll(*source);
    ASSERT_EQ(scans.size(), 2u);
    EXPECT_EQ(source->skipped().withoutPose, 1u);
    expectPoseNear(scans[0].T_map_robot, CPose3D(1, 2, 3, 0, 0, 0));
    expectPoseNear(scans[1].T_map_robot, CPose3D(2, 2, 3, 0, 0, 0));

    options.posesFile = folder.write("b.tum", "20 1 2 3 0 0 0 1\n");
    EXPECT_NE(errorOf(path, options).find("no pose is at the time of a scan"),
              std::string::npos)
        << errorOf(path, options);
    options.posesFile = folder / "absent.tum";
    EXPECT_NE(errorOf(path, options).find("absent.tum"), std::string::npos);

    options.poses = PoseOrigin::fixed;
    const auto fixed = readAll(path, options);
    ASSERT_EQ(fixed.size(), 3u);
    expectPoseNear(fixed[2].T_map_robot, CPose3D());
}

TEST(RawlogSource, saysThatPosesOrScansAreMissing) {
    TempFolder folder;
    auto path = writeRawlog(folder / "a.rawlog", {makeCloud(10, 1)});
    EXPECT_NE(errorOf(path).find("holds no robot poses"), std::string::npos) << errorOf(path);
    path = writeRawlog(folder / "b.rawlog", {makePose(10, CPose3D())});
    EXPECT_NE(errorOf(path).find("holds no scans"), std::string::npos) << errorOf(path);
    path = writeRawlog(folder / "c.rawlog", {makePose(10, CPose3D()), makeCloud(20, 1)});
    EXPECT_NE(errorOf(path).find("no pose is at the time of a scan"), std::string::npos);
    path = writeRawlog(folder / "d.rawlog", {});
    EXPECT_NE(errorOf(path).find("holds no scans"), std::string::npos) << errorOf(path);
}

/// Cuts a rawlog at many lengths: never a crash, never a silently shorter map.
template <class Stream>
void checkTruncation(bool objectBordersAreVisible) {
    TempFolder folder;
    const auto whole =
        readWholeFile(writeRawlog<Stream>(folder / "whole.rawlog", posedScans(6)));
    ASSERT_GT(whole.size(), 1000u);
    ScanSourceOptions accept;
    accept.truncation = Truncation::accept;
    int refused = 0, accepted = 0;
    for (std::size_t length = 1; length < whole.size(); length += 97) {
        const auto path = folder.write("cut.rawlog", whole.substr(0, length));
        const auto message = errorOf(path);
        if (objectBordersAreVisible) {
            EXPECT_NE(message, "no exception") << length;
        }
        if (message == "no exception") continue;
        ++refused;
        EXPECT_NE(message.find("cut.rawlog"), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        if (message.find("scans before it: 0") != std::string::npos) continue;
        if (message.find("scans before it: ") == std::string::npos) continue;
        const auto source = openScanSource(path, accept);
        EXPECT_FALSE(source->warning().empty());
        const auto scans = readAll(*source);
        EXPECT_NE(message.find("scans before it: " + std::to_string(scans.size())),
                  std::string::npos)
            << message << ", delivered " << scans.size();
        for (std::size_t i = 0; i < scans.size(); ++i)
            EXPECT_EQ(
                pointsOf(*scans[i].observation),
                pointsOf(*makeCloud(100.0 + static_cast<double>(i), static_cast<unsigned>(i))));
        ++accepted;
    }
    EXPECT_GT(refused, 20);
    EXPECT_GT(accepted, 10);
}

TEST(RawlogSource, refusesTruncatedPlainFiles) {
    checkTruncation<mrpt::io::CFileOutputStream>(false);
}

TEST(RawlogSource, refusesTruncatedCompressedFiles) {
    checkTruncation<mrpt::io::CFileGZOutputStream>(true);
}

TEST(RawlogSource, refusesWhatIsNoRawlog) {
    TempFolder folder;
    std::mt19937 random(5);
    int cases = 0;
    for (int i = 0; i < 200; ++i, ++cases) {
        std::string noise(1 + random() % 2000, ' ');
        for (char& c : noise) c = static_cast<char>(random());
        const auto message = errorOf(folder.write("noise.rawlog", noise));
        EXPECT_NE(message, "no exception");
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    EXPECT_EQ(cases, 200);
    EXPECT_NE(
        errorOf(folder.write("text.rawlog", "Hello, I am a text.\n")).find("not a rawlog"),
        std::string::npos);
    EXPECT_NE(errorOf(folder / "absent.rawlog").find("no such file"), std::string::npos);
    EXPECT_NE(errorOf(folder.write("a.xyz", "")).find("unknown input"), std::string::npos);
}

/// As in a file.
std::string bytesOf(const mrpt::serialization::CSerializable* object) {
    mrpt::io::CMemoryStream stream;
    mrpt::serialization::archiveFrom(stream).WriteObject(object);
    const auto* data = static_cast<const char*>(stream.getRawBufferData());
    return std::string(data, stream.getTotalBytesCount());
}

TEST(RawlogSource, refusesObjectsThatAreNoneAndObservationsThatAreNone) {
    TempFolder folder;
    const auto scan = makeCloud(1, 1);
    mrpt::obs::CSensoryFrame frame;
    frame.insert(scan);
    const std::string null = bytesOf(nullptr), observation = bytesOf(scan.get()),
                      whole = bytesOf(&frame);
    const auto begin = whole.find(observation);
    ASSERT_NE(begin, std::string::npos);
    const std::string one("\1\0\0\0", 4), two("\2\0\0\0", 4);
    const auto count = whole.rfind(one, begin);
    ASSERT_NE(count, std::string::npos);
    const auto frameWith = [&](const std::string& second) {
        std::string bytes = whole;
        bytes.insert(begin + observation.size(), second);
        return bytes.replace(count, 4, two);
    };
    ScanSourceOptions fixed;
    fixed.poses = PoseOrigin::fixed;
    const auto errorWith = [&](const std::string& bytes) {
        return errorOf(folder.write("a.rawlog", bytes), fixed);
    };
    EXPECT_EQ(errorWith(observation + frameWith(observation)), "no exception");
    const std::string tail = bytesOf(makeCloud(2, 2).get());
    for (const std::string& after : {std::string(), tail}) {
        expectPart(errorWith(observation + null + after), "an object is null, after 1 whole");
        expectPart(errorWith(observation + frameWith(null) + after),
                   "a sensory frame holds what is no observation, after 1 whole");
        const CPose2D pose;
        expectPart(errorWith(observation + frameWith(bytesOf(&pose)) + after),
                   "a sensory frame holds what is no observation");
    }
}

TEST(RawlogSource, findsExternallyStoredCloudsBesideTheRawlog) {
    TempFolder folder;
    const auto expected = makeCloud(1, 7);
    {
        mrpt::io::CFileGZOutputStream file(folder.write("log_Images/cloud.bin", ""));
        auto archive = mrpt::serialization::archiveFrom(file);
        archive << *expected->pointcloud;
    }
    auto external = makeCloud(1, 7);
    external->pointcloud.reset();
    external->setAsExternalStorage(
        "cloud.bin",
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    const auto path = writeRawlog(folder / "log.rawlog", {makePose(1, CPose3D()), external});
    const auto source = openScanSource(path);
    const auto scan = source->next();
    ASSERT_TRUE(scan);
    scan->observation->load();
    EXPECT_EQ(pointsOf(*scan->observation), pointsOf(*expected));
}

TEST(RawlogSource, readsTheRealSequences) {
    struct Sequence {
        const char *name, *label;
        std::uint64_t scans;
    };
    for (const Sequence& s : {Sequence{"rgbd_room", "KINECT", 100},
                              {"ouster_hall", "OUSTER", 30},
                              {"kitti_hdl64", "HDL64", 30}}) {
        const std::string base = std::string(SUPERRAY_SHARED_DATA_DIR) + "/" + s.name;
        if (!std::filesystem::exists(base + ".rawlog"))
            GTEST_SKIP() << "REAL DATA ABSENT: " << base << ".rawlog; NOT TESTED";
        const auto poses = Trajectory::load(base + ".tum");
        EXPECT_EQ(poses.size(), s.scans);
        const auto source = openScanSource(base + ".rawlog");
        EXPECT_EQ(source->total(), s.scans);
        std::uint64_t scans = 0;
        while (const auto scan = source->next()) {
            EXPECT_EQ(scan->observation->sensorLabel, s.label);
            const auto expected = poses.at(scan->timestamp);
            ASSERT_TRUE(expected);
            expectPoseNear(scan->T_map_robot, *expected, 1e-6);
            ++scans;
        }
        EXPECT_EQ(scans, s.scans);
    }
}

}  // namespace
}  // namespace superray
