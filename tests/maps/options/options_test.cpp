// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/config/CConfigFileMemory.h>
#include <superray/maps/option_text.h>
#include <superray/maps/options.h>

#include <random>
#include <sstream>

#include "maps/test_scans.h"

namespace superray {
namespace {

using mrpt::config::CConfigFileMemory;
using test::messageOf;

std::size_t linesOf(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Options, TextRoundTripKeepsEveryBit) {
    const std::string text = test::unusualOptions().toText();
    TMapOptions read;
    read.fromText(text);
    EXPECT_EQ(read.toText(), text);
    EXPECT_EQ(read.creation.resolution, 1.0 / 7);
    EXPECT_EQ(read.insertion.heightBandMin, -1.0 / 3);

    // Every line but the section headers, load_from and lazy_load_path differs from the
    // default.
    const std::string defaults = TMapOptions().toText();
    ASSERT_EQ(linesOf(text), linesOf(defaults));
    ASSERT_EQ(linesOf(text), 4u + 8u + 24u + 5u + 6u);
    std::istringstream a(text), b(defaults);
    std::size_t same = 0;
    for (std::string x, y; std::getline(a, x) && std::getline(b, y);) same += x == y ? 1 : 0;
    EXPECT_EQ(same, 6u);
}

void expectProbabilities(const TInsertionOptions& o, const SensorProbabilities& p) {
    EXPECT_EQ(o.probHit, p.probHit);
    EXPECT_EQ(o.probMiss, p.probMiss);
    EXPECT_EQ(o.clampingThresMin, p.clampMin);
    EXPECT_EQ(o.clampingThresMax, p.clampMax);
    EXPECT_EQ(o.occupancyThres, p.occupancyThreshold);
    EXPECT_EQ(o.scanHitMax, p.scanHitMax);
    EXPECT_EQ(o.scanMissMin, p.scanMissMin);
}

TInsertionOptions loaded(const std::string& lines) {
    TInsertionOptions o;
    o.loadFromConfigFile(CConfigFileMemory("[s]\n" + lines), "s");
    return o;
}

TEST(Options, EveryPolicyHasProbabilitiesOfItsOwn) {
    for (const UpdatePolicy policy : kUpdatePolicies) {
        TInsertionOptions o;
        o.setPolicy(policy);
        EXPECT_EQ(o.policy, policy);
        expectProbabilities(o, SensorProbabilities::defaultsOf(policy));
        const auto read = loaded(std::string("policy = ") + toString(policy) + "\n");
        EXPECT_EQ(read.policy, policy);
        expectProbabilities(read, SensorProbabilities::defaultsOf(policy));
    }
    EXPECT_EQ(SensorProbabilities::defaultsOf(UpdatePolicy::everyRay).probHit, 0.7);
    EXPECT_EQ(SensorProbabilities::defaultsOf(UpdatePolicy::netEvidence).probHit, 0.9);
}

TEST(Options, ProbabilitiesWithoutAPolicyAreThoseOfAnOctoMapConfiguration) {
    const auto octomap = loaded("probHit = 0.75\n");
    EXPECT_EQ(octomap.policy, UpdatePolicy::oncePerScan);
    EXPECT_EQ(octomap.probHit, 0.75);
    EXPECT_EQ(octomap.probMiss, 0.4);
    EXPECT_EQ(octomap.clampingThresMin, 0.1192);
    EXPECT_EQ(loaded("probMiss = 0.3\n").policy, UpdatePolicy::oncePerScan);
    // Keys that do not say what a ray means leave the policy alone.
    EXPECT_EQ(loaded("clampingThresMin = 0.2\nmaxrange = 5\n").policy,
              UpdatePolicy::netEvidence);
    const auto net = loaded("probHit = 0.8\npolicy = netEvidence\n");
    EXPECT_EQ(net.policy, UpdatePolicy::netEvidence);
    EXPECT_EQ(net.probHit, 0.8);
    EXPECT_EQ(net.probMiss, 0.475);
}

TEST(Options, Defaults) {
    const TInsertionOptions o;
    EXPECT_EQ(o.policy, UpdatePolicy::netEvidence);
    expectProbabilities(o, SensorProbabilities::defaultsOf(o.policy));
    EXPECT_EQ(o.superRayThreshold, 20u);
    EXPECT_EQ(o.rangeLimits().maximum, std::numeric_limits<double>::infinity());
    EXPECT_NO_THROW(o.validate());
}

TEST(Options, SavingToAConfigFileAndLoadingGivesTheSame) {
    const auto o = test::unusualOptions();
    CConfigFileMemory file;
    o.creation.saveToConfigFile(file, "m_creationOpts");
    o.insertion.saveToConfigFile(file, "m_insertOpts");
    o.likelihood.saveToConfigFile(file, "m_likelihoodOpts");
    o.rendering.saveToConfigFile(file, "m_renderOpts");
    TMapOptions read;
    read.loadFromConfigFile(file, "m");
    EXPECT_EQ(read.toText(), o.toText());
}

// A label is refused, or given back by a configuration file, its text and a saved map.
TEST(Options, TextsAreRefusedOrKept) {
    const std::vector<std::string> parts{
        "a",   "B",       " ",        "#", ";", "/",  "//", "${a}",    "$",  "{", "}", "=",
        "<<<", "$env{a}", "$eval{1}", "[", "]", "\"", "\\", "@define", "\t", ",", "%", "'"};
    std::mt19937 random(7);
    int kept = 0, refused = 0;
    for (int i = 0; i < 20000; ++i) {
        TMapOptions options;
        std::string& label = options.insertion.sensorLabel;
        for (auto n = 1 + random() % 5; n > 0; --n) label += parts[random() % parts.size()];
        SCOPED_TRACE("label \"" + label + "\"");
        try {
            options.insertion.validate();
        } catch (const std::invalid_argument&) {
            ++refused;
            continue;
        }
        ++kept;
        CConfigFileMemory saved;
        options.insertion.saveToConfigFile(saved, "s");
        // As from a file: MRPT's parser sees the text.
        const CConfigFileMemory file(saved.getContent());
        TInsertionOptions loaded;
        ASSERT_NO_THROW(loaded.loadFromConfigFile(file, "s"));
        ASSERT_EQ(loaded.sensorLabel, label);
        TMapOptions read;
        ASSERT_NO_THROW(read.fromText(options.toText()));
        ASSERT_EQ(read.insertion.sensorLabel, label);
    }
    EXPECT_GT(kept, 5000);
    EXPECT_GT(refused, 2000);
}

TEST(Options, TextsOfFilesAreMadePrintable) {
    EXPECT_EQ(printable("a \xC3\xA9\n\x1b[2J"), "a \xC3\xA9\\x0a\\x1b[2J");
}

TEST(Options, CommentsAndCaseOfKeysAreAccepted) {
    const CConfigFileMemory file(
        std::string("[s]\n"
                    "MaxRange = 7.5   // metres\n"
                    "probhit  = 0.8   # as measured\n"
                    "threads  = 2 ; two\n"
                    "heightBandMax = +1.5\n"));
    TInsertionOptions o;
    o.loadFromConfigFile(file, "s");
    EXPECT_EQ(o.maxrange, 7.5);
    EXPECT_EQ(o.probHit, 0.8);
    EXPECT_EQ(o.threads, 2u);
    EXPECT_EQ(o.heightBandMax, 1.5);
    EXPECT_EQ(o.probMiss, 0.4);
}

TEST(Options, AnUnknownKeyNamesTheClosest) {
    const CConfigFileMemory file(
        std::string("[map_insertOpts]\nmaxrange = 5\nprobHitt = 0.8\n"));
    TInsertionOptions o;
    const auto message = messageOf([&] { o.loadFromConfigFile(file, "map_insertOpts"); });
    EXPECT_CONTAINS(message, "[map_insertOpts]");
    EXPECT_CONTAINS(message, "probHitt");
    EXPECT_CONTAINS(message, "did you mean probHit?");
    EXPECT_EQ(o.maxrange, -1) << "nothing may change on error";
}

TEST(Options, AnUnknownSectionNamesTheClosest) {
    const CConfigFileMemory file(std::string("[map_00_insertionOpts]\nmaxrange = 5\n"));
    TMapOptions o;
    const auto message = messageOf([&] { o.loadFromConfigFile(file, "map_00"); });
    EXPECT_CONTAINS(message, "map_00_insertionOpts");
    EXPECT_CONTAINS(message, "did you mean [map_00_insertOpts]?");
}

struct BadLine {
    const char *section, *key, *value, *rule;
};

TEST(Options, BadValuesNameSectionKeyValueAndRule) {
    const std::vector<BadLine> lines{
        {"creationOpts", "resolution", "0", "1e-6 <= resolution"},
        {"creationOpts", "resolution", "-0.1", "1e-6 <= resolution"},
        {"creationOpts", "resolution", "nan", "1e-6 <= resolution"},
        {"creationOpts", "resolution", "1e-310", "1e-6 <= resolution"},
        {"creationOpts", "resolution", "1e+300", "resolution <= 1e6"},
        {"creationOpts", "resolution", "0.1m", "must be a number"},
        {"creationOpts", "lazy_load_path", "/no/such/folder", "must be a folder"},
        {"creationOpts", "reserve_megabytes", "1048577", "reserve_megabytes <= 1048576"},
        {"creationOpts", "reserve_megabytes", "-1", "whole number"},
        {"creationOpts", "max_memory_megabytes", "1048577", "max_memory_megabytes <= 1048576"},
        {"creationOpts", "max_memory_megabytes", "1.5", "whole number"},
        {"insertOpts", "windowRadius", "-1", "windowRadius >= 0"},
        {"insertOpts", "windowRadius", "inf", "windowRadius >= 0"},
        {"creationOpts", "enableSaveAs3DObject", "maybe", "must be true or false"},
        {"insertOpts", "probHit", "0.5", "0.5 < probHit < 1"},
        {"insertOpts", "probMiss", "0.5", "0 < probMiss < 0.5"},
        {"insertOpts", "clampingThresMin", "0.98", "clampingThresMin"},
        {"insertOpts", "clampingThresMax", "0.1", "clampingThresMax"},
        {"insertOpts", "occupancyThres", "1", "occupancyThres < 1"},
        {"insertOpts", "scanHitMax", "0.5", "0.5 < scanHitMax < 1"},
        {"insertOpts", "scanMissMin", "0", "0 < scanMissMin < 0.5"},
        {"insertOpts", "policy", "twice", "everyRay, oncePerScan or netEvidence"},
        {"insertOpts", "method", "fast", "superRays"},
        {"insertOpts", "threads", "0", "threads"},
        {"insertOpts", "threads", "-1", "whole number"},
        {"insertOpts", "decimation", "0", "decimation >= 1"},
        {"insertOpts", "decimation", "1.5", "whole number"},
        {"insertOpts", "minrange", "-1", "minrange >= 0"},
        {"insertOpts", "maxrange", "", "must be a number"},
        {"insertOpts", "heightBandMin", "inf", "heightBandMin < heightBandMax"},
        {"insertOpts", "sweepDuration", "-1", "sweepDuration >= 0"},
        {"likelihoodOpts", "sigma", "0", "1e-6 <= sigma"},
        {"likelihoodOpts", "maxDistance", "-1", "1e-6 <= maxDistance"},
        {"likelihoodOpts", "uniformWeight", "1", "uniformWeight < 1"},
        {"likelihoodOpts", "unknownLikelihood", "1.1", "unknownLikelihood <= 1"},
        {"likelihoodOpts", "decimation", "0", "decimation >= 1"},
        {"renderOpts", "colour", "red", "height or occupancy"},
    };
    ASSERT_EQ(lines.size(), 37u);
    for (const auto& line : lines) {
        const CConfigFileMemory file("[m_" + std::string(line.section) + "]\n" + line.key +
                                     " = " + line.value + "\n");
        TMapOptions o;
        const auto message = messageOf([&] { o.loadFromConfigFile(file, "m"); });
        EXPECT_CONTAINS(message, "[m_" + std::string(line.section) + "]");
        EXPECT_CONTAINS(message, std::string(line.key) + " = " + line.value);
        EXPECT_CONTAINS(message, line.rule);
        EXPECT_EQ(o.toText(), TMapOptions().toText());
    }
}

TEST(Options, MinimumMustBeBelowMaximumRange) {
    TInsertionOptions o;
    o.minrange = 5;
    EXPECT_NO_THROW(o.validate());
    o.maxrange = 5;
    EXPECT_CONTAINS(messageOf([&] { o.validate(); }), "minrange < maxrange");
}

TEST(Options, TextThatIsNotOursIsRejected) {
    TMapOptions o;
    EXPECT_THROW(o.fromText("resolution = 1\n"), std::invalid_argument);
    EXPECT_THROW(o.fromText("[creationOpts]\nresolution 1\n"), std::invalid_argument);
    EXPECT_THROW(o.fromText("[creationOpts]\nsize = 1\n"), std::invalid_argument);
    EXPECT_THROW(o.fromText("[otherOpts]\n"), std::invalid_argument);
    EXPECT_EQ(o.toText(), TMapOptions().toText());
    o.insertion.sensorLabel = "two\nlines";
    EXPECT_THROW(o.toText(), std::invalid_argument);
    EXPECT_THROW(o.insertion.validate(), std::invalid_argument);
}

TEST(Options, SensorLabels) {
    TInsertionOptions o;
    EXPECT_TRUE(o.acceptsSensor("anything"));
    o.sensorLabel = "KINECT, LASER 2";
    EXPECT_TRUE(o.acceptsSensor("KINECT"));
    EXPECT_TRUE(o.acceptsSensor("LASER 2"));
    EXPECT_FALSE(o.acceptsSensor("LASER"));
    EXPECT_FALSE(o.acceptsSensor(""));
}

}  // namespace
}  // namespace superray
