// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <superray/eval/input_error.h>
#include <superray/eval/trajectory.h>

#include <cmath>

#include "eval/sources/pose_matchers.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using mrpt::poses::CPose3D;
using test::messageOf;
using test::TempFolder;

Trajectory::Time at(double seconds) {
    return mrpt::Clock::fromDouble(seconds);
}

void expectPose(const std::optional<CPose3D>& pose, const CPose3D& expected,
                double tolerance = 1e-12) {
    ASSERT_TRUE(pose.has_value());
    test::expectPoseNear(*pose, expected, tolerance);
}

TEST(Trajectory, readsTum) {
    TempFolder folder;
    const double s = std::sqrt(0.5);
    const auto t = Trajectory::load(folder.write(
        "a.tum", "# comment\n\n10 1 2 3 0 0 0 1\r\n\t11.5  4 5 6 0 0 " + std::to_string(s) +
                     " " + std::to_string(s) + "\n% also a comment\n"));
    ASSERT_EQ(t.size(), 2u);
    expectPose(t.at(at(10)), CPose3D(1, 2, 3, 0, 0, 0));
    expectPose(t.at(at(11.5)), CPose3D(4, 5, 6, M_PI / 2, 0, 0));
}

TEST(Trajectory, readsMrptColumnsInAnyOrder) {
    TempFolder folder;
    const auto t =
        Trajectory::load(folder.write("a.txt", "11 4 5 6 0.1 -0.2 0.3\n10 1 2 3 0 0 1.5\n"));
    ASSERT_EQ(t.size(), 2u);
    expectPose(t.at(at(10)), CPose3D(1, 2, 3, 0, 0, 1.5), 0);
    expectPose(t.at(at(11)), CPose3D(4, 5, 6, 0.1, -0.2, 0.3), 0);
    EXPECT_EQ(t.firstTime(), at(10));
    EXPECT_EQ(t.lastTime(), at(11));
}

TEST(Trajectory, interpolatesOnTheStraightLineAtConstantRate) {
    Trajectory t;
    t.add(at(10), CPose3D(0, 0, 0, 0, 0, 0));
    t.add(at(12), CPose3D(4, -2, 1, 1.0, 0, 0));
    expectPose(t.at(at(10.5)), CPose3D(1, -0.5, 0.25, 0.25, 0, 0), 1e-9);
}

TEST(Trajectory, interpolatesTheShortestWayRound) {
    Trajectory t;
    t.add(at(0), CPose3D(0, 0, 0, 3.0, 0, 0));
    t.add(at(1), CPose3D(0, 0, 0, -3.0, 0, 0));
    expectPose(t.at(at(0.5)), CPose3D(0, 0, 0, M_PI, 0, 0), 1e-9);
}

TEST(Trajectory, takesPosesWithinAMicrosecondAsTheyAre) {
    Trajectory t;
    t.add(at(10), CPose3D(1, 0, 0, 0, 0, 0));
    t.add(at(11), CPose3D(2, 0, 0, 0, 0, 0));
    expectPose(t.at(at(10 + 5e-7)), CPose3D(1, 0, 0, 0, 0, 0), 0);
    expectPose(t.at(at(11 - 5e-7)), CPose3D(2, 0, 0, 0, 0, 0), 0);
    expectPose(t.at(at(11 + 5e-7)), CPose3D(2, 0, 0, 0, 0, 0), 0);
}

TEST(Trajectory, outsideItsTimesThereIsNoPoseButForTheSlack) {
    Trajectory t;
    EXPECT_FALSE(t.at(at(10)));
    t.add(at(10), CPose3D(1, 0, 0, 0, 0, 0));
    t.add(at(11), CPose3D(2, 0, 0, 0, 0, 0));
    EXPECT_FALSE(t.at(at(9.96)));
    EXPECT_FALSE(t.at(at(11.04)));
    PoseLimits slack;
    slack.slack = 0.05;
    EXPECT_FALSE(t.at(at(9.94), slack));
    EXPECT_FALSE(t.at(at(11.06), slack));
    expectPose(t.at(at(9.96), slack), CPose3D(1, 0, 0, 0, 0, 0), 0);
    expectPose(t.at(at(11.04), slack), CPose3D(2, 0, 0, 0, 0, 0), 0);
}

TEST(Trajectory, readsWhatOtherProgramsMakeOfTables) {
    TempFolder folder;
    // A byte order mark, a heading, commas, and carriage returns.
    const auto commas =
        Trajectory::load(folder.write("a.csv",
                                      "\xEF\xBB\xBFtimestamp,x,y,z,qx,qy,qz,qw\r\n"
                                      "10,1,2,3,0,0,0,1\r\n11, 4, 5, 6, 0, 0, 0, 1\r\n"));
    ASSERT_EQ(commas.size(), 2u);
    expectPose(commas.at(at(10)), CPose3D(1, 2, 3, 0, 0, 0), 0);
    expectPose(commas.at(at(11)), CPose3D(4, 5, 6, 0, 0, 0), 0);
    const auto marked =
        Trajectory::load(folder.write("b.tum", "\xEF\xBB\xBF# a comment\n10 1 2 3 0 0 0 1\n"));
    EXPECT_EQ(marked.size(), 1u);
    const auto mulran = Trajectory::load(
        folder.write("global_pose.csv", "1600000000500000000,1,0,0,7,0,1,0,8,0,0,1,9\n"));
    ASSERT_EQ(mulran.size(), 1u);
    expectPose(mulran.at(at(1600000000.5)), CPose3D(7, 8, 9, 0, 0, 0), 1e-12);
}

TEST(Trajectory, skipsAndCountsRowsThatAreNotFinite) {
    TempFolder folder;
    const auto t = Trajectory::load(folder.write(
        "a.tum", "1 0 0 0 0 0 0 1\n2 nan 0 0 0 0 0 1\n3 0 0 inf 0 0 0 1\n4 1 0 0 0 0 0 1\n"));
    EXPECT_EQ(t.size(), 2u);
    EXPECT_EQ(t.skippedRows(), 2u);
}

TEST(Trajectory, rowsThatAreRepeatedAreOnePose) {
    TempFolder folder;
    const auto t = Trajectory::load(
        folder.write("a.tum",
                     "1 1 2 3 0 0 0.6 0.8\n2 0 0 0 0 0 0 1\n1 1 2 3 0 0 0.6 0.8\n"
                     "1.0 1 2 3 0 0 -0.6 -0.8\n"));
    EXPECT_EQ(t.size(), 2u);
}

TEST(Trajectory, namesOfColumnsMustBeThoseThatAreRead) {
    TempFolder folder;
    const std::string tum = "1 0 0 0 0 0 0 1\n", mrpt = "1 0 0 0 0 0 0\n",
                      commas = "1,0,0,0,0,0,0,1\n";
    const std::string goods[] = {
        "time x y z qx qy qz qw\n" + tum,
        "# timestamp tx ty tz qx qy qz qw\n" + tum,
        "timestamp [s],p_x [m],p_y [m],p_z [m],q_x,q_y,q_z,q_w\n" + commas,
        "t;X;Y;Z;QX;QY;QZ;QW\n1;0;0;0;0;0;0;1\n",
        "field.header.stamp,field.pose.position.x,field.pose.position.y,"
        "field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,"
        "field.pose.orientation.z,field.pose.orientation.w\n" +
            commas,
        "t x y z x y z w\n" + tum,
        "# robot poses in x, y and z, by time\n" + tum,
        "Poses of the robot\n" + tum,
        "a b c d e f g h\n" + tum,
        "# time x y z yaw pitch roll\n" + mrpt,
        "TIMESTAMP X Y Z YAW PITCH ROLL\n" + mrpt,
        "# timestamp x y z qx qy qz qw (robot pose in the map frame)\n" + tum,
        "# roll, pitch and yaw were made quaternions: x y z qx qy qz qw\n" + tum};
    for (const auto& good : goods)
        EXPECT_EQ(Trajectory::load(folder.write("a.txt", good)).size(), 1u) << good;
    struct Case {
        std::string contents, expected;
    };
    const Case cases[] = {
        {"time x y z qw qx qy qz\n" + tum, "column 5 is 'qw', read as qx"},
        {"t,x,y,z,q_w,q_x,q_y,q_z\n" + commas, "column 5 is 'q_w', read as qx"},
        {"x y z qx qy qz qw t\n" + tum, "column 1 is 'x', read as t"},
        {"t,y,x,z,qx,qy,qz,qw\n" + commas, "column 2 is 'y', read as x"},
        {"t x y z roll pitch yaw\n" + mrpt, "column 5 is 'roll', read as yaw"},
        {"t x y z rx ry rz\n" + mrpt, "column 5 is 'rx', read as yaw"},
        {"t x y qx qy qz qw\n" + mrpt, "column 4 is 'qx', read as z"},
        {"t x y z qx qy qz qw\n" + mrpt, "the order x y z qx qy qz qw, read as x y z yaw"},
        {"# timestamp tx ty tz qw qx qy qz\n" + tum, "the order tx ty tz qw qx qy qz, read"},
        {"# columns: t, qx, qy, qz, qw, x, y, z\n" + tum, "the order qx qy qz qw x y z"},
        {"% time x y z roll pitch yaw (rad)\n" + mrpt, "the order x y z roll pitch yaw"},
        {"# t x y z yaw pitch roll\n" + tum, "the order x y z yaw pitch roll, read"},
        {"#ts p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
         "q_RS_z []\n" +
             commas,
         "q_RS_w q_RS_x q_RS_y q_RS_z, read as x y z qx qy qz qw"}};
    for (const Case& c : cases) {
        const auto path = folder.write("a.txt", c.contents);
        const auto message = messageOf<InputError>([&] { Trajectory::load(path); });
        test::expectPart(message, path + ":1: ");
        test::expectPart(message, c.expected);
    }
}

TEST(Trajectory, saysWhereAFileIsWrong) {
    TempFolder folder;
    struct Case {
        const char *contents, *expected;
    };
    const Case cases[] = {
        {"", "holds no pose"},
        {"# only\n", "holds no pose"},
        {"1 2 3\n", ":1: has 3 columns"},
        {"1 0 0 0 0 0 0\n2 0 0 0 0 0 0 1\n", ":2: has 8 columns, the lines before have 7"},
        {"1 0 0 0 0 0 0 1\n2 0 0 x 0 0 0 1\n", ":2: every column must be a finite number"},
        {"1 0 0 0 0 0 0 1\n\n2 0 0 1.5e 0 0 0 1\n", ":3: every column must be a finite number"},
        {"1 0 nan 0 0 0 0 1\n", ":1: every column must be a finite number"},
        {"1 0 0 inf 0 0 0\n", ":1: every column must be a finite number"},
        {"1,0,0,0,0,0,0,a\n", ":1: every column must be a finite number"},
        {"1 0 0 0 0 1 0 0 0 0 1 0\n", "KITTI's 12 columns have no times"},
        {"1 2 0 0 0 0 1 0 0 0 0 1 0\n", ":1: the left 3x3 part"},
        // A mirror; and a scale.
        {"1 1 0 0 0 0 1 0 0 0 0 -1 0\n", ":1: the left 3x3 part"},
        {"1 1.003 0 0 0 0 1 0 0 0 0 1 0\n", ":1: the left 3x3 part"},
        // Empty fields, and commas of decimals, are no blanks.
        {"1,0,0,,0,0,0,1\n", ":1: column 4 is empty"},
        {"1;0;0; ;0;0;0;1\n", ":1: column 4 is empty"},
        {"t,x,y,z,qx,qy,qz,qw\n,0,0,0,0,0,0,1\n", ":2: column 1 is empty"},
        {"1,0,0,0,0,0,0,1,\n", ":1: column 9 is empty"},
        {"1 1,5 0 0 0 0 1\n", ":1: every column must be a finite number"},
        {"1,0;1,5;0;0;0;0;1\n", ":1: every column must be a finite number"},
        {"1,0 0 0 0 0 0 1\n", ":1: every column must be a finite number"},
        // Two places at one time.
        {"1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n\n2 1 5 0 0 0 0 1\n",
         ":4: time 2.000000 has another pose than in line 2"},
        {"1 0 0 0 0 0 0\n1.0 0 0 0 0.01 0 0\n",
         ":2: time 1.000000 has another pose than in line 1"},
        {"t,x,y,z\n", "holds no pose"},
        {"1 0 0 0 0 0 0 0\n", ":1: the quaternion"},
        {"1 0 0 0 0 0 0 1.1\n", ":1: the quaternion"},
        {"1500000000000000000 0 0 0 0 0 0 1\n", ":1: time"},
    };
    for (const auto& c : cases) {
        const std::string path = folder.write("bad.txt", c.contents);
        const auto message = messageOf<InputError>([&] { Trajectory::load(path); });
        EXPECT_NE(message.find(path), std::string::npos) << message;
        EXPECT_NE(message.find(c.expected), std::string::npos)
            << c.contents << " -> " << message;
    }
    EXPECT_THROW(Trajectory::load(folder / "absent.txt"), InputError);
    EXPECT_THROW(Trajectory::load(folder / "."), InputError);
}

}  // namespace
}  // namespace superray
