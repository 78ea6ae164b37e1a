// SPDX-License-Identifier: BSD-3-Clause
// superray-bench itself: what it writes, prints and returns.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/engines/bench_scans.h"
#include "eval/run_program.h"
#include "eval/temp_folder.h"

namespace superray {
namespace {

using namespace test;

ProgramResult run(const TempFolder& folder, const std::string& arguments) {
    return runProgram(folder, SUPERRAY_BENCH_APP, arguments);
}

std::string runOk(const TempFolder& folder, const std::string& arguments) {
    const auto r = run(folder, arguments);
    EXPECT_EQ(r.code, 0) << arguments << "\n" << r.error;
    return r.out;
}

void expectError(const TempFolder& folder, const std::string& arguments,
                 const std::string& part) {
    const auto r = run(folder, arguments);
    EXPECT_EQ(r.code, 2) << arguments;
    EXPECT_NE(r.error.find("superray-bench: error: "), std::string::npos) << r.error;
    EXPECT_NE(r.error.find(part), std::string::npos) << arguments << "\n" << r.error;
}

TEST(BenchCli, comparesAndWritesJson) {
    TempFolder folder;
    const std::string in = " '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    const auto text = runOk(folder, "compare" + in +
                                        "--resolutions 0.2,0.4 --engines octomap,grid,octree "
                                        "--threads 1,2 --figures '" +
                                        (folder / "out.json") + "'");
    EXPECT_NE(text.find("small, 0.4 m, 3 scans"), std::string::npos) << text;
    const auto document = nlohmann::json::parse(readWholeFile(folder / "out.json"));
    ASSERT_EQ(document["runs"].size(), 10u);
    for (const auto& r : document["runs"])
        for (const char* field : {"data", "resolution", "engine", "threads", "ms_per_scan",
                                  "ratio_to_octomap", "map_bytes", "digest"})
            EXPECT_TRUE(r.contains(field) && !r[field].is_null()) << field;
}

TEST(BenchCli, comparesSimulatedWorldsWithoutAFile) {
    TempFolder folder;
    const auto several = runOk(folder,
                               "compare --scans 1 --resolutions 0.8,1 --engines grid "
                               "indoor outdoor");
    for (const char* part : {"indoor, 0.8 m", "indoor, 1 m", "outdoor, 1 m, 1 scans, 247,817"})
        EXPECT_NE(several.find(part), std::string::npos) << several;
    const auto text = runOk(
        folder, "compare indoor --scans 1 --resolutions 0.4 --engines grid,octree --seed 3");
    EXPECT_NE(text.find("indoor, 0.4 m, 1 scans, 89,446 points"), std::string::npos) << text;
}

TEST(BenchCli, simulatesRecordings) {
    TempFolder folder;
    const std::string out = "'" + (folder / "a.rawlog") + "'";
    const auto text = runOk(folder, "simulate indoor --scans 2 --resolution 0.2 -o " + out);
    EXPECT_NE(text.find("2 of 89,446 points"), std::string::npos) << text;
    EXPECT_TRUE(std::filesystem::exists(folder / "a.tum"));
    const auto table = runOk(folder, "compare --resolutions 0.4 --engines grid " + out);
    EXPECT_NE(table.find("a, 0.4 m, 2 scans, 89,446 points"), std::string::npos) << table;
    expectError(folder, "simulate moon -o " + out, "moon");
    expectError(folder, "simulate indoor", "--output");
    expectError(folder, "simulate indoor --scans 0 -o " + out, "at least 1");
    expectError(folder, "simulate indoor -o a.txt", ".rawlog");
    expectError(folder, "simulate indoor --scans -1 -o " + out, "must be a whole number");
    expectError(folder, "simulate indoor --seed '' -o " + out, "must be a whole number");
}

TEST(BenchCli, whatCannotBeWrittenIsSaidPlainly) {
    TempFolder folder;
    std::filesystem::create_symlink("/dev/full", folder / "x.rawlog");
    expectError(folder, "simulate indoor --scans 2 -o '" + (folder / "x.rawlog") + "'",
                "No space left");
    std::filesystem::create_symlink(folder / "b.rawlog", folder / "b.tum");
    expectError(folder, "simulate indoor --scans 1 -o '" + (folder / "b.rawlog") + "'",
                "would overwrite another output");
    const auto file = folder.write("file", "");
    for (const std::string& name : {file, file + "/within"}) {
        const auto r = run(folder, "paper indoor --scans 1 -o '" + name + "'");
        EXPECT_EQ(r.code, 2);
        expectPart(r.error, "file is a file, must be a folder");
        EXPECT_EQ(std::count(r.error.begin(), r.error.end(), '\n'), 1)
            << "nothing was measured before: " << r.error;
    }
}

TEST(BenchCli, valuesThatWouldCountAsNotGivenAreErrors) {
    TempFolder folder;
    for (const char* option : {"--engines ''", "--sensor ''", "--poses ''", "--figures ''"})
        expectError(folder, "compare indoor --scans 1 " + std::string(option),
                    "must not be empty");
    expectError(folder, "compare indoor --scans 1 --resolutions 0.5,nan", "'nan' is not a");
    expectError(folder, "realtime indoor --scans 1 --rate nan", "'nan' is not a number");
    expectError(folder, "soak indoor --scans 1 --max-memory -1", "must be a whole number");
    expectError(folder, "accuracy indoor --scans 1 --slice 0,1", "--slice requires --picture");
    const std::string in = "compare '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    expectError(folder, in + "--engines grid --sensor NOPE", "NOPE");
    const std::string link = folder / "a.json";
    std::filesystem::create_symlink(folder / "small.rawlog", link);
    expectError(folder, in + "--engines grid --figures '" + link + "'",
                "would overwrite the input");
    EXPECT_FALSE(readWholeFile(folder / "small.rawlog").empty());
}

TEST(BenchCli, replaysInRealTime) {
    TempFolder folder;
    const std::string in = " '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    const auto json = folder / "out.json";
    const auto text = runOk(folder, "realtime" + in +
                                        "--rate 0.01 --engines grid --threads 1,2 "
                                        "--keep-all-points --figures '" +
                                        json + "'");
    EXPECT_NE(text.find("all points"), std::string::npos) << text;
    const auto runs = nlohmann::json::parse(readWholeFile(json))["runs"];
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_EQ(runs[1]["scans_lost"], 0);
    expectError(folder, "realtime" + in + "--rate 0", "rate");
    expectError(folder, "realtime" + in + "--rate ''", "must be a number");
    expectError(folder, "realtime" + in + "--scans -1", "must be a whole number");
    expectError(folder, "realtime absent.rawlog", "absent.rawlog");
}

nlohmann::json accuracyOf(const TempFolder& folder, const std::string& arguments) {
    const auto document = nlohmann::json::parse(
        runOk(folder,
              "accuracy indoor --scans 2 --resolutions 0.4 --policies netEvidence "
              "--models shared --json " +
                  arguments));
    return document["runs"];
}

TEST(BenchCli, tellsHowTrueMapsAre) {
    TempFolder folder;
    const auto runs = accuracyOf(folder, "--engines grid,octomap");
    ASSERT_EQ(runs.size(), 2u);
    for (const auto& run : runs) {
        double tested = 0, right = 0;
        for (const char* kind : {"occupied", "free"}) {
            const double ofKind = run[kind]["tested"];
            EXPECT_NEAR(ofKind, 0.2 * 2 * 89446, 500) << "a fifth of the points is held out";
            tested += ofKind;
            right += run[kind]["right"].get<double>();
            double inRanges = 0;
            for (const auto& range : run["by_range"])
                inRanges += range[kind]["tested"].get<double>();
            EXPECT_EQ(inRanges, ofKind);
        }
        EXPECT_NEAR(run["accuracy"], right / tested, 1e-9);
        EXPECT_LE(run["accuracy"], run["ceiling"]);
    }
    EXPECT_GT(runs[0]["accuracy"], 0.9);
    EXPECT_GT(runs[0]["truth"]["iou"], 0.7);
    const auto noisy = accuracyOf(folder, "--engines grid --pose-noise 0.3,3");
    EXPECT_LT(noisy[0]["accuracy"], runs[0]["accuracy"]);
    EXPECT_LT(noisy[0]["truth"]["iou"], runs[0]["truth"]["iou"]);
}

TEST(BenchCli, drawsMapsOverTheTruth) {
    TempFolder folder;
    const auto text = runOk(folder,
                            "accuracy indoor --scans 1 --resolutions 0.4 "
                            "--engines grid --policies netEvidence,everyRay --picture '" +
                                (folder / "maps.png") + "'");
    EXPECT_NE(text.find("everyRay"), std::string::npos) << text;
    EXPECT_EQ(readWholeFile(folder / "maps.png").substr(1, 3), "PNG");
    expectError(folder, "accuracy indoor --pose-noise 1", "--pose-noise needs two numbers");
}

TEST(BenchCli, soaksAndJudges) {
    TempFolder folder;
    const std::string in = " '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    const std::string rest = "--resolution 0.4 --figures '" + (folder / "soak.json") +
                             "' --insertions 200 --window ";
    const auto flat = runOk(folder, "soak" + in + rest + "3");
    EXPECT_NE(flat.find("memory is flat"), std::string::npos) << flat;
    const auto json = nlohmann::json::parse(readWholeFile(folder / "soak.json"));
    EXPECT_EQ(json["runs"][0]["scans"], 200);
    const auto grows = run(folder, "soak" + in + rest + "0");
    EXPECT_EQ(grows.code, 1) << grows.out;
    EXPECT_NE(grows.out.find("GROWS"), std::string::npos) << grows.out;
    EXPECT_EQ(
        nlohmann::json::parse(runOk(folder, "soak" + in + rest + "3 --json"))["runs"].size(),
        1u);
    expectError(folder, "soak" + in + "--json out.json", "--figures out.json");
    expectError(folder, "soak" + in + in, "soak replays one DATA");
    expectError(folder, "soak" + in + "--resolution 0.02 --window 0 --max-memory 1",
                "max_memory_megabytes = 1");
}

TEST(BenchCli, writesThePapersTables) {
    TempFolder folder;
    const std::string in = " '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    const auto text = runOk(folder, "paper" + in + "--resolutions 0.5 --thresholds 20 -o '" +
                                        (folder / "paper") + "'");
    EXPECT_NE(text.find("octree-full"), std::string::npos) << text;
    EXPECT_TRUE(std::filesystem::exists(folder / "paper/table4_memory.csv"));
    expectError(folder, "paper" + in, "--output");
    expectError(folder, "paper absent.rawlog -o '" + (folder / "paper") + "'", "absent.rawlog");
    expectError(folder, "paper" + in + "--thresholds 0 -o '" + (folder / "paper") + "'",
                "superRayThreshold");
}

TEST(BenchCli, jsonIsPrintedAsInAllPrograms) {
    TempFolder folder;
    const std::string in = " '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    for (const char* command : {"compare --engines grid", "realtime --engines grid",
                                "accuracy --engines grid --resolutions 0.4"}) {
        const auto printed = nlohmann::json::parse(runOk(folder, command + in + "--json"));
        EXPECT_TRUE(printed.is_object() && !printed.empty()) << command;
        // As earlier versions took it.
        for (const char* file : {" out.json", " OUT.JSON"})
            expectError(folder, command + in + "--json" + file,
                        "--json takes no file, got '" + std::string(file).substr(1) + "'");
        expectError(folder, command + in + "--json=out.json", "--figures out.json writes");
    }
    // Both at once, as benchmarks.sh wants it.
    const auto file = folder / "both.json";
    const auto printed =
        runOk(folder, "compare --json --engines grid --figures '" + file + "'" + in);
    EXPECT_EQ(printed, readWholeFile(file));
}

TEST(BenchKernels, allRunAndCount) {
    TempFolder folder;
    const auto r = runProgram(folder, SUPERRAY_KERNELS_APP,
                              "--benchmark_filter=outdoor:0/cm:40 --benchmark_min_time=0.001 "
                              "--benchmark_format=json");
    ASSERT_EQ(r.code, 0) << r.error;
    const auto kernels = nlohmann::json::parse(r.out)["benchmarks"];
    EXPECT_GE(kernels.size(), 24u);
    for (const auto& kernel : kernels) {
        double rate = 0;  // of whatever it counts
        for (const char* counted : {"cells", "rays", "points"})
            if (kernel.contains(counted)) rate = kernel[counted].get<double>();
        EXPECT_GT(rate, 1e3) << kernel["name"];
    }
}

TEST(BenchCli, helpTeachesAndErrorsAreOneLine) {
    TempFolder folder;
    const std::string in = " '" + writeSmallRecording(folder / "small.rawlog") + "' ";
    for (const char* command : {"", "compare", "paper", "realtime", "simulate"})
        EXPECT_NE(runOk(folder, std::string(command) + " --help").find("  superray-bench "),
                  std::string::npos);
    EXPECT_NE(runOk(folder, "compare --help").find("mrpt-grid3d"), std::string::npos);
    expectError(folder, "", "subcommand");
    expectError(folder, "compare", "required");
    expectError(folder, "compare absent.rawlog", "absent.rawlog");
    expectError(folder, "compare" + in + "--engines gird", "gird");
    expectError(folder, "compare" + in + "--policy seldom", "seldom");
    expectError(folder, "compare" + in + "--resolutions 0", "resolution");
    expectError(folder, "compare" + in + "--threads 0", "threads");
    expectError(folder, "compare" + in + "--scans 0", "at least 1");
    expectError(folder, "compare" + in + "--figures out.txt", "out.txt");
    expectError(folder, "compare" + in + "--figures '" + (folder / "none/out.json") + "'",
                "does not exist");
}

}  // namespace
}  // namespace superray
