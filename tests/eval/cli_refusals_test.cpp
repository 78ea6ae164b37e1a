// SPDX-License-Identifier: BSD-3-Clause
// What superray-map refuses, before any work, instead of doing something else.

#include <gtest/gtest.h>

#include <algorithm>

#include "eval/recorded_scans.h"
#include "eval/run_program.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;
using mrpt::poses::CPose3D;
namespace fs = std::filesystem;

class Refusals : public testing::Test {
 protected:
    void SetUp() override {
        Objects objects;
        for (int i = 0; i < 2; ++i) {
            objects.push_back(makePose(i, CPose3D(0.3 * i, 0, 0, 0, 0, 0)));
            objects.push_back(makeCloud(i, static_cast<unsigned>(i), "LIDAR", 100));
        }
        writeRawlog(folder_ / "a.rawlog", objects);
    }

    ProgramResult run(const std::string& arguments) {
        return runProgram(folder_, SUPERRAY_MAP_APP, arguments);
    }
    std::string path(const std::string& name) { return " '" + (folder_ / name) + "' "; }
    std::string build(const std::string& options, const std::string& output = "a.srmap") {
        return "build" + path("a.rawlog") + "-o" + path(output) + options;
    }
    /// One line on stderr with all parts; exit code 2.
    void expectError(const std::string& arguments, const std::vector<std::string>& parts) {
        const auto r = run(arguments);
        EXPECT_EQ(r.code, 2) << arguments;
        EXPECT_EQ(std::count(r.error.begin(), r.error.end(), '\n'), 1) << r.error;
        for (const auto& part : parts) expectPart(r.error, part);
    }
    void expectOk(const std::string& arguments) {
        const auto r = run(arguments);
        EXPECT_EQ(r.code, 0) << arguments << "\n" << r.error;
    }

    TempFolder folder_;
};

TEST_F(Refusals, outputsThatAreInputs) {
    const std::string recording = readWholeFile(folder_ / "a.rawlog");
    fs::create_symlink(folder_ / "a.rawlog", folder_ / "link.srmap");
    fs::create_hard_link(folder_ / "a.rawlog", folder_ / "hard.srmap");
    for (const char* output : {"link.srmap", "hard.srmap"})
        expectError(build("", output), {output, "would overwrite the input", "a.rawlog"});
    EXPECT_EQ(readWholeFile(folder_ / "a.rawlog"), recording);

    const std::string poses = "0 0 0 0 0 0 0 1\n1 0.3 0 0 0 0 0 1\n";
    folder_.write("poses.srmap", poses);
    expectError(build("--poses" + path("./poses.srmap"), "poses.srmap"), {"would overwrite"});
    EXPECT_EQ(readWholeFile(folder_ / "poses.srmap"), poses);
    folder_.write("cfg.srmap", "[m_creationOpts]\nresolution = 0.2\n");
    expectError(build("--section m --config" + path("cfg.srmap"), "cfg.srmap"),
                {"would overwrite"});

    expectOk(build(""));
    expectOk("export" + path("a.srmap") + path("a.ot"));
    expectError("export" + path("a.ot") + path("a.ot"), {"would overwrite the input"});
    expectOk(build("--map CSuperRayGridMap2D", "plan.srmap"));
    fs::create_symlink(folder_ / "plan.srmap", folder_ / "plan.pgm");
    expectError("export" + path("plan.srmap") + path("plan.yaml"),
                {"plan.pgm", "would overwrite the input"});
    expectOk("info" + path("plan.srmap"));
}

TEST_F(Refusals, butAMapMayGoOnInItself) {
    expectOk(build(""));
    folder_.write("on.ini", "[m_creationOpts]\nload_from = " + (folder_ / "a.srmap") + "\n");
    expectOk(build("--section m --config" + path("on.ini")));
    for (const char* name : {"n.srmap", "n.ply"})
        fs::create_symlink("/dev/null", folder_ / name);
    expectOk(build("", "n.srmap"));
    expectOk("export" + path("a.srmap") + path("n.ply"));
}

TEST_F(Refusals, linesOfAnIniFileThatWouldNotBeRead) {
    using namespace std::string_literals;
    const std::string start = "[m_creationOpts]\nresolution = 0.3\n[m_insertOpts]\n";
    const struct {
        std::string text, place, rule;
    } files[] = {
        {"[m_creationOpts]\nresolution = 0.3 # \0\n[m_insertOpts]\nmaxrange = 3\n"s, "2",
         "NUL"},
        {"[m_creationOpts]\n# \\\n\0\n"s, "3", "NUL"},
        {start + "maxrange: 3\n", "4", "'maxrange: 3' must be 'key = value'"},
        {start + "maxrange 3\n", "4", "must be 'key = value'"},
        {start + "= 3\n", "4", "must be 'key = value'"},
        {"maxrange = 3\n" + start, "1", "before any section"},
        {start + "# folder c:\\\nmaxrange = 3\n", "4", "takes the next line"},
        {start + "minrange = 1 // \\\r\nmaxrange = 3\r\n", "4", "takes the next line"},
        {"# \\\n" + start, "1", "takes the next line"},
        {start + "# a\\\n# b\\\nmaxrange = 3\n", "4", "takes the next line"},
        {"[m_insertOpts\nmaxrange = 3\n", "1", "']' is missing"},
        {"[m_insertOpts] maxrange = 3\n", "1", "'maxrange = 3' after"},
        {start + "maxrange = ${A}\n", " Line 4", "Unknown variable"},
    };
    for (const auto& file : files) {
        folder_.write("a.ini", file.text);
        expectError(build("--section m --config" + path("a.ini")),
                    {"a.ini:" + file.place, file.rule});
    }
    EXPECT_FALSE(fs::exists(folder_ / "a.srmap"));
}

TEST_F(Refusals, butWhatTheParserKnowsOrOthersReadIsNoError) {
    folder_.write("a.ini",
                  "\xEF\xBB\xBF@define R 0.2\n// no \\\n\n[other]\nfree text: 1\n[x]junk\n"
                  "f = a; \\\nb\n"
                  "[M_creationOpts] ; ours\r\nresolution = ${R} // [m] \r\n# c \\\n# d\n"
                  "[m_insertOpts]\nmaxrange = \\\n  3 # [m]\n@define Q 1\n");
    expectOk(build("--section m --config" + path("a.ini")));
    const auto info = run("info" + path("a.srmap")).out;
    expectPart(info, "resolution  0.2 m");
    expectPart(info, "maxrange = 3\n");
    expectOk(build("--section map --config '" SUPERRAY_CONFIG_DIR "/superray-maps-basic.ini'"));
}

TEST_F(Refusals, longValuesAreShortened) {
    const std::string longText(200000, 'x');
    for (const std::string& line : {"maxrange = " + longText, longText + " = 3", longText}) {
        folder_.write("a.ini", "[m_insertOpts]\n" + line + "\n");
        const auto r = run(build("--section m --config" + path("a.ini")));
        EXPECT_EQ(r.code, 2);
        EXPECT_LT(r.error.size(), 1000u) << line.substr(0, 20);
        expectPart(r.error, "a.ini");
        expectPart(r.error, "(200000 characters)");
    }
}

TEST_F(Refusals, labelsThatNoSensorHas) {
    expectError(build("--sensor LIDAR,NOPE"), {"'NOPE'", "the labels are 'LIDAR'"});
    expectPart(run("inspect" + path("a.rawlog") + "--sensor LIDAR,NOPE").out, "'NOPE'");
    writeRawlog(folder_ / "b.rawlog", {makePose(0, CPose3D()), makeCloud(0, 1, "REAR", 100)});
    expectOk("build" + path("a.rawlog") + path("b.rawlog") + "--sensor LIDAR,REAR -o" +
             path("a.srmap"));
    expectError("build" + path("a.rawlog") + path("b.rawlog") + "--sensor LIDAR,REAR,X -o" +
                    path("a.srmap"),
                {"'X'", "'LIDAR', 'REAR'"});
}

TEST_F(Refusals, emptyTexts) {
    for (const char* option : {"--poses", "--config", "--sensor", "--pose-label", "--map",
                               "--policy", "--method", "--pose-source", "--section"})
        for (const char* value : {" ''", " ' '", " ,"})
            expectError(build(option + std::string(value)), {option, "must not be empty"});
    expectError("build '' -o" + path("a.srmap"), {"must not be empty"});
    expectError("inspect" + path("a.rawlog") + "--sensor ''",
                {"--sensor", "must not be empty"});
}

TEST_F(Refusals, numbersThatAreNone) {
    for (const char* option : {"--resolution", "--max-range", "--min-range", "--window",
                               "--max-pose-gap", "--depth-units"}) {
        expectError(build(option + std::string(" nan")), {option, "'nan' is not a number"});
        expectError(build(option + std::string(" 0,1")), {option, "'0,1' is not a number"});
        expectError(build(option + std::string(" 1e999")), {option, "is out of range"});
    }
    expectError(build("--max-memory -1"), {"'-1' must be a whole number"});
    expectError(build("--threads 4294967297"), {"--threads = 4294967297", "out of range"});
    expectError(build("--scans 0"), {"scans = 0"});
    expectOk(build(""));
    expectError("export" + path("a.srmap") + path("a.png") + "--cut-above nan",
                {"--cut-above", "'nan' is not a number"});
    expectError("export" + path("a.srmap") + path("a.png") + "--width 99999999999999",
                {"--width", "out of range"});
}

TEST_F(Refusals, camerasThatCannotBe) {
    for (const char* values :
         {"inf 50 32 24", "50 0 32 24", "0 50 32 24", "50 -1 32 24", "50 50 32 inf"})
        expectError(build("--intrinsics " + std::string(values)),
                    {"--intrinsics ", "must be finite"});
    expectError(build("--intrinsics 50 50 nan 24"), {"--intrinsics", "'nan' is not a number"});
    for (const char* value : {"inf", "0", "-5000"})
        expectError(build("--depth-units " + std::string(value)),
                    {"--depth-units = " + std::string(value), "must be finite and > 0"});
}

TEST_F(Refusals, camerasWhereThereAreNone) {
    for (const char* option : {"--intrinsics 50 50 32 24", "--depth-units 1000"})
        expectError(build(option), {"a.rawlog", "for RGB-D folders"});
}

TEST_F(Refusals, recordingsThatAreGivenTwice) {
    folder_.write("b.rawlog", readWholeFile(folder_ / "a.rawlog"));
    fs::create_symlink(folder_ / "a.rawlog", folder_ / "link.rawlog");
    for (const char* name : {"a.rawlog", "./a.rawlog", "link.rawlog"})
        expectError("build" + path("a.rawlog") + path(name) + "-o" + path("a.srmap"),
                    {name, "is given twice"});
    expectOk("build" + path("a.rawlog") + path("b.rawlog") + "-o" + path("a.srmap"));
}

TEST_F(Refusals, optionsThatContradictEachOther) {
    folder_.write("a.tum", "0 0 0 0 0 0 0 1\n1 0.3 0 0 0 0 0 1\n");
    const std::string label = " --pose-label POSE";
    for (const char* origin : {"--fixed-robot", "--pose-source fixed", "--pose-source actions"})
        expectError(build(origin + label), {origin, "--pose-label POSE", "contradicts"});
    expectError(build("--poses" + path("a.tum") + label), {"--poses", "contradicts"});
    expectOk(build(label));
    for (const char* name : {"a.ot", "a.ply", "a.3Dscene"})
        for (const char* option : {"--width", "--height", "--cut-above"})
            expectError("export" + path("a.srmap") + path(name) + option + " 500",
                        {option, name, "contradicts"});
    expectOk("export" + path("a.srmap") + path("a.png") + "--width 500 --cut-above 1");
    expectOk(build("--map CSuperRayGridMap2D"));
    expectError("export" + path("a.srmap") + path("b.png") + "--width 500",
                {"--width", "2D map"});
}

}  // namespace
}  // namespace superray
