// SPDX-License-Identifier: BSD-3-Clause
// The program itself: what it writes, prints and returns.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <regex>

#include "eval/recorded_scans.h"
#include "eval/run_program.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;

ProgramResult run(const TempFolder& folder, const std::string& arguments) {
    return runProgram(folder, SUPERRAY_MAP_APP, arguments);
}

std::string runOk(const TempFolder& folder, const std::string& arguments) {
    const auto r = run(folder, arguments);
    EXPECT_EQ(r.code, 0) << arguments << "\n" << r.error;
    EXPECT_EQ(r.error.find("rror"), std::string::npos) << arguments << "\n" << r.error;
    return r.out;
}

/// One line on stderr, naming `part`; exit code 2.
void expectError(const TempFolder& folder, const std::string& arguments,
                 const std::string& part) {
    const auto r = run(folder, arguments);
    EXPECT_EQ(r.code, 2) << arguments;
    EXPECT_EQ(r.error.rfind("superray-map: error: ", 0), 0u) << r.error;
    EXPECT_EQ(std::count(r.error.begin(), r.error.end(), '\n'), 1) << r.error;
    EXPECT_NE(r.error.find(part), std::string::npos) << arguments << "\n" << r.error;
}

std::string digestOf(const TempFolder& folder, const std::string& map) {
    const auto json = runOk(folder, "info --json '" + map + "'");
    std::smatch match;
    EXPECT_TRUE(std::regex_search(json, match, std::regex("\"digest\": \"([0-9a-f]{32})\"")));
    return match.size() == 2 ? match[1].str() : "";
}

std::string makeRecording(const TempFolder& folder) {
    Objects objects;
    for (int i = 0; i < 4; ++i) {
        objects.push_back(makePose(i, CPose3D(0.3 * i, 0, 0, 0.2 * i, 0, 0)));
        objects.push_back(makeCloud(i, static_cast<unsigned>(i), "LIDAR", 400));
    }
    return writeRawlog(folder / "a.rawlog", objects);
}

TEST(Cli, buildsInspectsExportsAndCompares) {
    TempFolder folder;
    const std::string in = "'" + makeRecording(folder) + "'";
    const auto file = [&](const std::string& name) { return " '" + (folder / name) + "'"; };

    const auto summary =
        runOk(folder, "build " + in + " -o" + file("a.srmap") + " --resolution 0.2");
    EXPECT_NE(summary.find("scans      4"), std::string::npos) << summary;
    EXPECT_NE(summary.find("rays       1,600"), std::string::npos) << summary;
    EXPECT_NE(summary.find("a.srmap"), std::string::npos) << summary;

    EXPECT_NE(runOk(folder, "info" + file("a.srmap")).find("CSuperRayGridMap3D"),
              std::string::npos);
    for (const char* name : {"a.ot", "a.bt", "a.ply", "a.3Dscene", "a.png"}) {
        runOk(folder, "export" + file("a.srmap") + file(name));
        EXPECT_GT(std::filesystem::file_size(folder / name), 0u);
    }
    for (const char* name : {"a.srmap", "a.ot", "a.bt"})
        EXPECT_NE(runOk(folder, "compare" + file("a.srmap") + file(name)).find("identical"),
                  std::string::npos);

    runOk(folder, "build " + in + " -o" + file("b.srmap") + " --resolution 0.2 --scans 3");
    const auto different = run(folder, "compare" + file("a.srmap") + file("b.srmap"));
    EXPECT_EQ(different.code, 1);
    EXPECT_NE(different.out.find("different"), std::string::npos);
    EXPECT_NE(digestOf(folder, folder / "a.srmap"), digestOf(folder, folder / "b.srmap"));

    runOk(folder, "build " + in + " -o" + file("plan.srmap") + " --map CSuperRayGridMap2D");
    runOk(folder, "export" + file("plan.srmap") + file("plan.png"));
    expectError(folder, "export" + file("plan.srmap") + file("plan.ot"), "plan.ot");
    expectError(folder, "compare" + file("a.srmap") + file("plan.srmap"), "dimensions");
}

TEST(Cli, memoryBoundAndWindow) {
    TempFolder folder;
    const std::string in = "build '" + makeRecording(folder) + "' -o '";
    const std::string fine = "' --resolution 0.02 ";
    const auto refused = run(folder, in + (folder / "a.srmap") + fine + "--max-memory 1");
    EXPECT_EQ(refused.code, 2);
    for (const char* part : {"max_memory_megabytes = 1", "scan ", "raise the bound"})
        EXPECT_NE(refused.error.find(part), std::string::npos) << refused.error;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.srmap"));
    runOk(folder, in + (folder / "a.srmap") + fine + "--max-memory 1000");
    runOk(folder, in + (folder / "b.srmap") + fine + "--max-memory 1000 --window 0.5");
    EXPECT_LT(std::filesystem::file_size(folder / "b.srmap"),
              std::filesystem::file_size(folder / "a.srmap") / 2);
    const auto bad = run(folder, in + (folder / "c.srmap") + fine + "--window -1");
    EXPECT_EQ(bad.code, 2);
}

TEST(Cli, helpTeachesAndVersionIsTold) {
    TempFolder folder;
    for (const char* arguments : {"--help", "build --help", "inspect --help", "info --help",
                                  "export --help", "compare --help"})
        EXPECT_NE(runOk(folder, arguments).find("  superray-map "), std::string::npos)
            << arguments;
    EXPECT_NE(runOk(folder, "--version").find("superray-map "), std::string::npos);
}

TEST(Cli, saysWhatIsWrongInOneLineAndKeepsTheOldOutput) {
    TempFolder folder;
    const auto recording = makeRecording(folder);
    const std::string in = " '" + recording + "'";
    const std::string out = " -o '" + folder.write("old.srmap", "old") + "' ";
    const auto whole = readWholeFile(recording);
    folder.write("cut.rawlog", whole.substr(0, whole.size() * 3 / 4));
    writeRawlog(folder / "poseless.rawlog", {makeCloud(1, 1)});
    const auto file = [&](const std::string& name) { return " '" + (folder / name) + "' "; };

    expectError(folder, "", "subcommand");
    expectError(folder, "frobnicate", "");
    expectError(folder, "build", "required");
    expectError(folder, "build" + in, "--output");
    expectError(folder, "build" + in + out + "--frobnicate", "--frobnicate");
    expectError(folder, "build" + file("absent.rawlog") + out, "absent.rawlog");
    expectError(folder, "build" + file("cut.rawlog") + out, "cut.rawlog");
    expectError(folder, "build" + file("poseless.rawlog") + out, "no robot poses");
    expectError(folder, "build" + in + " -o" + file("a.map"), "must end in .srmap");
    expectError(folder, "build" + in + " -o" + file("none/a.srmap"), "does not exist");
    expectError(folder, "build" + in + out + "--resolution 0", "resolution");
    expectError(folder, "build" + in + out + "--resolution nan", "resolution");
    expectError(folder, "build" + in + out + "--resolution wide", "--resolution");
    expectError(folder, "build" + in + out + "--max-range 1 --min-range 2", "range");
    expectError(folder, "build" + in + out + "--threads 0", "threads");
    expectError(folder, "build" + in + out + "--scans 0", "at least 1");
    expectError(folder, "build" + in + out + "--method fast", "fast");
    expectError(folder, "build" + in + out + "--policy seldom", "seldom");
    expectError(folder, "build" + in + out + "--map COctoMap", "COctoMap");
    expectError(folder, "build" + in + out + "--sensor CAMERA", "CAMERA");
    expectError(folder, "build" + in + out + "--poses" + file("absent.tum"), "absent.tum");
    expectError(folder, "build" + in + out + "--config" + file("absent.ini") + "--section s",
                "absent.ini");
    expectError(folder, "info" + file("absent.srmap"), "absent.srmap");
    expectError(folder, "info" + file("old.srmap"), "old.srmap");
    expectError(folder, "export" + file("old.srmap") + file("a.ot"), "old.srmap");
    expectError(folder, "compare" + file("old.srmap") + file("old.srmap"), "old.srmap");
    EXPECT_EQ(readWholeFile(folder / "old.srmap"), "old");

    runOk(folder, "build --accept-truncated" + file("cut.rawlog") + "-o" + file("cut.srmap"));
    runOk(folder, "build --fixed-robot" + file("poseless.rawlog") + "-o" + file("one.srmap"));
}

/// A value of one of our JSON outputs, as Python sees it.
std::string pythonOf(const TempFolder& folder, const std::string& json,
                     const std::string& expression) {
    folder.write("value.json", json);
    const auto r = runProgram(folder, "python3",
                              "-c 'import json; j = json.load(open(\"" +
                                  (folder / "value.json") + "\")); print(" + expression + ")'");
    EXPECT_EQ(r.code, 0) << r.error << json;
    return r.out.substr(0, r.out.find('\n'));
}

TEST(Cli, jsonMeansOneObjectOnStandardOutputEverywhere) {
    TempFolder folder;
    if (std::system("python3 -c 'import json' 2>/dev/null") != 0)
        GTEST_SKIP() << "PYTHON3 ABSENT: JSON NOT TESTED";
    const std::string in = "'" + makeRecording(folder) + "'";
    const auto file = [&](const std::string& name) { return " '" + (folder / name) + "'"; };
    const auto value = [&](const std::string& arguments, const std::string& expression) {
        return pythonOf(folder, run(folder, arguments + " --json").out, expression);
    };
    EXPECT_EQ(value("build " + in + " -o" + file("a.srmap"), "j[\"scans\"]"), "4");
    runOk(folder, "build " + in + " -o" + file("b.srmap") + " --scans 3");
    EXPECT_EQ(value("build " + in + " -o" + file("a.srmap"), "j[\"poses\"][0]"),
              "robot poses 'POSE', 4, 0.0 to 3.0 s");
    EXPECT_EQ(value("build " + in + " -o" + file("a.srmap"), "j[\"digest\"]"),
              digestOf(folder, folder / "a.srmap"));
    EXPECT_EQ(value("compare" + file("a.srmap") + file("a.srmap"), "j[\"identical\"]"), "True");
    EXPECT_EQ(value("compare" + file("a.srmap") + file("b.srmap"), "j[\"identical\"]"),
              "False");
    EXPECT_EQ(value("inspect " + in, "j[\"build\"][\"possible\"], j[\"build\"][\"scans\"]"),
              "True 4");
    EXPECT_EQ(value("inspect " + in, "j[\"sensors\"][0][\"label\"]"), "LIDAR");
    EXPECT_EQ(run(folder, "compare" + file("a.srmap") + file("b.srmap") + " --json").code, 1);
}

TEST(Cli, inspectTellsWhatThereIsAndWhatBuildWouldDo) {
    TempFolder folder;
    const auto good = runOk(folder, "inspect '" + makeRecording(folder) + "'");
    const auto expectPart = [](const std::string& text, const std::string& part) {
        EXPECT_NE(text.find(part), std::string::npos) << text;
    };
    expectPart(good, "format      MRPT rawlog");
    expectPart(good, "sensor      'LIDAR' CObservationPointCloud: 4, 0.0 to 3.0 s, 1.00 Hz");
    expectPart(good, "400 points a scan, ranges ");
    expectPart(good, "sensor      'POSE' CObservationRobotPose: 4");
    expectPart(good, "has poses   robot poses 'POSE' (4)");
    expectPart(good, "build       4 scans");
    expectPart(good, "poses: robot poses 'POSE', 4, 0.0 to 3.0 s");

    auto gps = makePose(0.5, CPose3D(9, 9, 0, 0, 0, 0));
    gps->sensorLabel = "GPS";
    auto external = makeCloud(1, 7);
    external->pointcloud.reset();
    external->setAsExternalStorage(
        "absent.bin",
        mrpt::obs::CObservationPointCloud::ExternalStorageFormat::MRPT_Serialization);
    writeRawlog(folder / "b.rawlog", {makePose(0, CPose3D()), gps, makeCloud(0, 1), external});
    const auto bad = runOk(folder, "inspect '" + (folder / "b.rawlog") + "'");
    expectPart(bad, "build       not possible: ");
    expectPart(bad, "robot poses of 2 labels, 'GPS' (1), 'POSE' (1)");
    expectPart(bad, "external files: 0 of 1 found, missing: absent.bin");
    expectPart(bad, "looked in   " + (folder / "b_Images"));
    const auto whole = readWholeFile(folder / "a.rawlog");
    folder.write("cut.rawlog", whole.substr(0, whole.size() * 3 / 4));
    expectPart(runOk(folder, "inspect '" + (folder / "cut.rawlog") + "'"), "damage      ");
    expectError(folder, "inspect '" + (folder / "absent.rawlog") + "'", "no such file");
    expectError(folder, "inspect '" + folder.write("a.clf", "FLASER 180") + "'",
                "carmen2rawlog");
    expectError(
        folder,
        "build '" + (folder / "a.rawlog") + "' --sensor X -o '" + (folder / "a.srmap") + "'",
        "its labels are 'LIDAR' (4)");
}

TEST(Cli, emptyAndNegativeNumbersAreErrors) {
    TempFolder folder;
    const std::string base =
        "build '" + makeRecording(folder) + "' -o '" + (folder / "a.srmap") + "' ";
    for (const char* option :
         {"--resolution ''", "--max-range ' '", "--min-range ''", "--max-pose-gap ''"})
        expectError(folder, base + option, "must be a number, is empty");
    for (const char* option : {"--scans -1", "--scans 1.5", "--threads -2", "--scans ''"})
        expectError(folder, base + option, "must be a whole number, at least 1");
    expectError(folder, base + "--pose-source gps", "must be one of auto, file");
    expectError(folder, base + "--pose-source file", "needs --poses FILE");
}

TEST(Cli, deskewingThatDoesNothingIsTold) {
    TempFolder folder;
    const auto summary = runOk(folder, "build '" + makeRecording(folder) + "' --deskew -o '" +
                                           (folder / "a.srmap") + "'");
    EXPECT_NE(summary.find("nothing was de-skewed"), std::string::npos) << summary;
}

TEST(Cli, octomapFilesAreMapsEverywhere) {
    TempFolder folder;
    const auto file = [&](const std::string& name) { return " '" + (folder / name) + "' "; };
    runOk(folder, "build '" + makeRecording(folder) + "' -o" + file("a.srmap"));
    runOk(folder, "export" + file("a.srmap") + file("a.ot"));
    runOk(folder, "export" + file("a.srmap") + file("a.bt"));
    EXPECT_EQ(digestOf(folder, folder / "a.ot"), digestOf(folder, folder / "a.srmap"));
    EXPECT_NE(runOk(folder, "info" + file("a.bt")).find("CSuperRayOctoMap"), std::string::npos);
    runOk(folder, "export" + file("a.ot") + file("b.ply"));
    folder.write("a.ini", "[m_creationOpts]\nload_from = " + (folder / "a.ot") + "\n");
    runOk(folder, "build '" + (folder / "a.rawlog") + "' --config" + file("a.ini") +
                      "--section m -o" + file("more.srmap"));
}

TEST(Cli, jsonIsValid) {
    TempFolder folder;
    if (std::system("python3 -c 'import json' 2>/dev/null") != 0)
        GTEST_SKIP() << "PYTHON3 ABSENT: JSON NOT TESTED";
    const std::string name = folder / "quo\"te\\ \xc3\xa9 \xff.srmap";
    writeRawlog(folder / "b.rawlog", {makePose(0, CPose3D()), makeCloud(0, 1, "LIDAR"),
                                      makeCloud(0, 2, "a \"quoted\" label")});
    runOk(folder, "build '" + (folder / "b.rawlog") + "' -o '" + name +
                      "' --sensor 'LIDAR,a \"quoted\" label'");
    const auto json = runOk(folder, "info --json '" + name + "'");
    const auto path = folder.write("info.json", json);
    EXPECT_EQ(std::system(("python3 -m json.tool '" + path + "' >/dev/null").c_str()), 0)
        << json;
}

struct Sequence {
    const char *name, *options;
    friend std::ostream& operator<<(std::ostream& out, const Sequence& s) {
        return out << s.options;
    }
};

class CliOnRealData : public testing::TestWithParam<Sequence> {};

/// The promise of the library: the same map by every way to compute it.
TEST_P(CliOnRealData, everyMethodGivesTheSameDigest) {
    TempFolder folder;
    const std::string in =
        std::string(SUPERRAY_SHARED_DATA_DIR) + "/" + GetParam().name + ".rawlog";
    if (!std::filesystem::exists(in))
        GTEST_SKIP() << "REAL DATA ABSENT: " << in << "; NOT TESTED";
    const auto out = folder / "a.srmap";
    std::string expected;
    int builds = 0;
    for (const char* method : {"reference", "perRay", "superRays", "culling", "full", "auto"}) {
        for (const char* threads : {"1", "2"}) {
            for (const char* map : {"CSuperRayGridMap3D", "CSuperRayOctoMap"}) {
                runOk(folder, "build '" + in + "' -o '" + out + "' " + GetParam().options +
                                  " --method " + method + " --threads " + threads + " --map " +
                                  map);
                const auto digest = digestOf(folder, out);
                if (expected.empty()) expected = digest;
                EXPECT_EQ(digest, expected) << method << " " << threads << " " << map;
                ++builds;
            }
        }
    }
    EXPECT_EQ(expected.size(), 32u);
    EXPECT_EQ(builds, 24);
}

// Two scans and short rays: the reference takes its time.
INSTANTIATE_TEST_SUITE_P(
    Sequences, CliOnRealData,
    testing::Values(Sequence{"rgbd_room", "--resolution 0.05 --scans 2"},
                    Sequence{"ouster_hall", "--resolution 0.2 --scans 2 --max-range 12"},
                    Sequence{"kitti_hdl64", "--resolution 0.2 --scans 2 --max-range 12"}),
    [](const auto& sequence) { return std::string(sequence.param.name); });

TEST(Cli, whatCannotBeWrittenIsAnError) {
    TempFolder folder;
    runOk(folder, "build '" + makeRecording(folder) + "' -o '" + (folder / "a.srmap") + "'");
    for (const char* name : {"x.ot", "x.bt", "x.ply", "x.3Dscene", "x.png"}) {
        std::filesystem::create_symlink("/dev/full", folder / name);
        const auto r =
            run(folder, "export '" + (folder / "a.srmap") + "' '" + (folder / name) + "'");
        EXPECT_EQ(r.code, 2) << name;
        EXPECT_NE(r.error.find("No space left"), std::string::npos) << r.error;
    }
    std::filesystem::create_symlink("/dev/full", folder / "x.srmap");
    const auto build =
        run(folder, "build '" + (folder / "a.rawlog") + "' -o '" + (folder / "x.srmap") + "'");
    EXPECT_EQ(build.code, 2);
    EXPECT_NE(build.error.find("No space left"), std::string::npos) << build.error;
    // The shell's redirection stands before that of runProgram().
    const auto info = run(folder, "info '" + (folder / "a.srmap") + "' > /dev/full #");
    EXPECT_EQ(info.code, 2);
    const auto closed = run(folder, "build '" + (folder / "a.rawlog") + "' -o '" +
                                        (folder / "c.srmap") + "' >&- #");
    EXPECT_EQ(closed.code, 0);
    EXPECT_EQ(readWholeFile(folder / "c.srmap"), readWholeFile(folder / "a.srmap"))
        << "what was printed went into the map";
}

TEST(Cli, fifosAreOutputs) {
    TempFolder folder;
    runOk(folder, "build '" + makeRecording(folder) + "' -o '" + (folder / "a.srmap") + "'");
    runOk(folder, "export '" + (folder / "a.srmap") + "' '" + (folder / "a.ply") + "'");
    const std::string fifo = folder / "fifo.ply";
    const auto r = runProgram(folder, "sh",
                              "-c \"mkfifo '" + fifo + "'; cat '" + fifo + "' > '" +
                                  (folder / "got") + "' & " SUPERRAY_MAP_APP " export '" +
                                  (folder / "a.srmap") + "' '" + fifo + "' && wait\"");
    EXPECT_EQ(r.code, 0) << r.error;
    EXPECT_EQ(readWholeFile(folder / "got"), readWholeFile(folder / "a.ply"));
}

}  // namespace
}  // namespace superray
