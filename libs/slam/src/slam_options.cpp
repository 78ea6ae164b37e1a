// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/config/CConfigFileMemory.h>
#include <superray/eval/config_text.h>
#include <superray/eval/input_error.h>
#include <superray/maps/option_text.h>
#include <superray/slam/slam_options.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace superray {
namespace {

// The one list of keys per section: loading and saving follow it.
// visit(key, member, comment)

template <class O, class Visit>
void visitRegistration(O& o, Visit visit) {
    visit("resolutions", o.resolutions, "[m] cells, coarse to fine");
    visit("decimation", o.decimation, "use one of so many measurements");
    visit("minRange", o.minRange, "[m]");
    visit("maxRange", o.maxRange, "[m]");
    visit("pointSpacing", o.pointSpacing, "[m] one point per cube");
    visit("rangeNoiseExponent", o.rangeNoiseExponent, "0 lidar, 2 structured light");
    visit("minPlanarity", o.minPlanarity, "in [0, 1]");
    visit("icp", o.icp, "MRPT's CICP first");
    visit("refinementSteps", o.refinementSteps, "per level, 0: CICP alone");
    visit("gate", o.gate, "in cells, at first");
    visit("smallestGate", o.smallestGate, "in cells, at least");
    visit("yawSearch", o.yawSearch, "[degrees] to either side, 0: none");
    visit("yawStep", o.yawStep, "[degrees]");
}

void require(bool rule, const char* key, double value, const char* text) {
    if (rule) return;
    throw std::invalid_argument(std::string(key) + " = " + formatValue(value) +
                                ": must satisfy " + text);
}

std::string priorName(MotionPrior prior) {
    switch (prior) {
        case MotionPrior::constantVelocity:
            return "constantVelocity";
        case MotionPrior::odometry:
            return "odometry";
        case MotionPrior::none:
            break;
    }
    return "none";
}

MotionPrior priorFrom(const std::string& text) {
    for (auto p : {MotionPrior::constantVelocity, MotionPrior::odometry, MotionPrior::none})
        if (equalIgnoringCase(text, priorName(p))) return p;
    throw std::invalid_argument("prior = " + shortened(text) +
                                ": must be one of constantVelocity, odometry, none");
}

/// All or nothing.
template <class Options, class Read>
void readStrictly(const mrpt::config::CConfigFileBase& source, const std::string& name,
                  Options& options, Read read) {
    Options updated = options;
    StrictSection section(source, name);
    try {
        read(section, updated);
        section.rejectUnknownKeys();
        updated.validate();
    } catch (const std::invalid_argument& e) {
        const std::string what = e.what();
        if (what.find("[" + name + "]") != std::string::npos) throw;
        throw std::invalid_argument("[" + name + "] " + what);
    }
    options = updated;
}

/// MRPT reads its options from what it knows and says nothing about the rest.
void rejectUnknownIcpKeys(const mrpt::config::CConfigFileBase& source) {
    mrpt::config::CConfigFileMemory known;
    mrpt::slam::CICP::TConfigParams().saveToConfigFile(known, "icp");
    std::vector<std::string> keys;
    known.getAllKeys("icp", keys);
    keys.emplace_back("thresholdAng_DEG");
    StrictSection section(source, "icp");
    for (const auto& key : keys) {
        std::string ignored;
        section.read(key.substr(0, key.find_last_not_of(' ') + 1), ignored);
    }
    section.rejectUnknownKeys();
}

constexpr int kKeyWidth = 24, kValueWidth = 16;

}  // namespace

void TRegistrationOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                              const std::string& section) {
    readStrictly(source, section, *this, [](StrictSection& s, auto& o) {
        visitRegistration(
            o, [&](const char* key, auto& value, const char*) { s.read(key, value); });
    });
}

void TRegistrationOptions::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                            const std::string& section) const {
    visitRegistration(*this, [&](const char* key, const auto& value, const char* comment) {
        target.write(section, key, formatValue(value), kKeyWidth, kValueWidth, comment);
    });
}

void TRegistrationOptions::validate() const {
    levels();
    require(decimation >= 1, "decimation", decimation, "decimation >= 1");
    require(std::isfinite(minRange) && minRange >= 0, "minRange", minRange, "minRange >= 0");
    require(maxRange > minRange, "maxRange", maxRange, "maxRange > minRange");
    require(std::isfinite(pointSpacing) && pointSpacing > 0, "pointSpacing", pointSpacing,
            "pointSpacing > 0");
    require(rangeNoiseExponent >= 0 && rangeNoiseExponent <= 4, "rangeNoiseExponent",
            rangeNoiseExponent, "0 <= rangeNoiseExponent <= 4");
    require(minPlanarity >= 0 && minPlanarity <= 1, "minPlanarity", minPlanarity,
            "0 <= minPlanarity <= 1");
    require(icp || refinementSteps > 0, "refinementSteps", refinementSteps,
            "refinementSteps > 0 where icp = false");
    require(std::isfinite(gate) && gate > 0, "gate", gate, "gate > 0");
    require(smallestGate > 0 && smallestGate <= gate, "smallestGate", smallestGate,
            "0 < smallestGate <= gate");
    require(yawSearch >= 0 && yawSearch <= 180, "yawSearch", yawSearch,
            "0 <= yawSearch <= 180");
    require(yawStep > 0.1 && yawStep <= 180, "yawStep", yawStep, "0.1 < yawStep <= 180");
}

std::vector<double> TRegistrationOptions::levels() const {
    const auto fail = [&] {
        throw std::invalid_argument("resolutions = " + shortened(resolutions) +
                                    ": must be numbers > 0, each smaller than the one before, "
                                    "separated by commas");
    };
    std::vector<double> result;
    std::istringstream list(resolutions);
    for (std::string entry; std::getline(list, entry, ',');) {
        const auto first = entry.find_first_not_of(" \t");
        if (first == std::string::npos) fail();
        double value = 0;
        try {
            parseValue(entry.substr(first, entry.find_last_not_of(" \t") - first + 1), value);
        } catch (const std::invalid_argument&) {
            fail();
        }
        if (!(std::isfinite(value) && value > 0) || (!result.empty() && value >= result.back()))
            fail();
        result.push_back(value);
    }
    if (result.empty()) fail();
    return result;
}

void TKeyFrameOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                          const std::string& section) {
    readStrictly(source, section, *this, [](StrictSection& s, TKeyFrameOptions& o) {
        std::string priorText = priorName(o.prior);
        s.read("prior", priorText);
        o.prior = priorFrom(priorText);
        s.read("insertionLinDistance", o.insertionLinDistance);
        s.read("insertionAngDistance", o.insertionAngDistance);
        s.read("minICPgoodness", o.minICPgoodness);
    });
}

void TKeyFrameOptions::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                        const std::string& section) const {
    const auto write = [&](const char* key, const std::string& value, const char* comment) {
        target.write(section, key, value, kKeyWidth, kValueWidth, comment);
    };
    write("prior", priorName(prior), "constantVelocity, odometry, none");
    write("insertionLinDistance", formatValue(insertionLinDistance), "[m]");
    write("insertionAngDistance", formatValue(insertionAngDistance), "[degrees]");
    write("minICPgoodness", formatValue(minICPgoodness), "in [0, 1]");
}

void TKeyFrameOptions::validate() const {
    require(std::isfinite(insertionLinDistance) && insertionLinDistance >= 0,
            "insertionLinDistance", insertionLinDistance, "insertionLinDistance >= 0");
    require(std::isfinite(insertionAngDistance) && insertionAngDistance >= 0,
            "insertionAngDistance", insertionAngDistance, "insertionAngDistance >= 0");
    require(minICPgoodness >= 0 && minICPgoodness <= 1, "minICPgoodness", minICPgoodness,
            "0 <= minICPgoodness <= 1");
}

TSlamOptions::TSlamOptions() {
    // The refinement does the fine work.
    icp.maxIterations = 10;
    icp.thresholdDist = 1.0;
    icp.smallestThresholdDist = 0.5;
    icp.thresholdAng = 0;
    icp.minAbsStep_trans = 1e-3;
    icp.minAbsStep_rot = 1e-4;
    icp.corresponding_points_decimation = 2;
    icp.skip_cov_calculation = true;
}

void TSlamOptions::loadFromFile(const std::string& path) {
    const auto config = readConfigFile(path, [](const std::string& section) {
        return section == "registration" || section == "keyframes" || section == "icp";
    });
    TSlamOptions updated = *this;
    bool any = false;
    try {
        if (config.sectionExists("registration")) {
            updated.registration.loadFromConfigFile(config, "registration");
            any = true;
        }
        if (config.sectionExists("keyframes")) {
            updated.keyFrames.loadFromConfigFile(config, "keyframes");
            any = true;
        }
        if (config.sectionExists("icp")) {
            rejectUnknownIcpKeys(config);
            updated.icp.loadFromConfigFile(config, "icp");
            any = true;
        }
        updated.validate();
    } catch (const std::exception& e) {
        throw std::invalid_argument(path + ": " + oneLineCause(e));
    }
    if (!any)
        throw std::invalid_argument(
            path + ": has none of the sections [registration], [keyframes], [icp]");
    *this = updated;
}

std::string TSlamOptions::toText() const {
    mrpt::config::CConfigFileMemory config;
    registration.saveToConfigFile(config, "registration");
    keyFrames.saveToConfigFile(config, "keyframes");
    icp.saveToConfigFile(config, "icp");
    return config.getContent();
}

void TSlamOptions::validate() const {
    registration.validate();
    keyFrames.validate();
    require(icp.ALFA > 0 && icp.ALFA < 1, "ALFA", icp.ALFA, "0 < ALFA < 1");
}

}  // namespace superray
