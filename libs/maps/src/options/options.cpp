// SPDX-License-Identifier: BSD-3-Clause
#include <superray/maps/options.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include <superray/maps/option_text.h>

#include "options/option_keys.h"

namespace superray {
namespace {

constexpr std::uint32_t kMostMegabytes = 1u << 20;  // more is a mistake in the unit

void require(bool rule, const char* key, double value, const char* text) {
    if (rule) return;
    throw std::invalid_argument(std::string(key) + " = " + formatValue(value) +
                                ": must satisfy " + text);
}

template <class Options>
void validateIn(const std::string& section, const Options& options) {
    if constexpr (!std::is_same_v<Options, TRenderingOptions>) {
        try {
            options.validate();
        } catch (const std::invalid_argument& e) {
            throw std::invalid_argument("[" + section + "] " + e.what());
        }
    }
}

/// Chooses the policy before single values are read; see TInsertionOptions.
void choosePolicy(StrictSection& section, TInsertionOptions& options) {
    UpdatePolicy policy = options.policy;
    if (section.has("policy"))
        StrictSection(section).read("policy", policy);
    else if (section.has("probHit") || section.has("probMiss"))
        policy = UpdatePolicy::oncePerScan;
    if (policy != options.policy) options.setPolicy(policy);
}

/// All or nothing.
template <class Options>
void readSection(StrictSection section, const std::string& name, Options& options) {
    Options updated = options;
    if constexpr (std::is_same_v<Options, TInsertionOptions>) choosePolicy(section, updated);
    visitOptions(updated,
                 [&](const char* key, auto& value, const char*) { section.read(key, value); });
    // octoMap's sections work here: its trees may be pruned or not, ours always are.
    bool pruning = true;
    if constexpr (std::is_same_v<Options, TInsertionOptions>) section.read("pruning", pruning);
    section.rejectUnknownKeys();
    validateIn(name, updated);
    options = updated;
}

template <class Options>
void writeSection(const Options& options, mrpt::config::CConfigFileBase& target,
                  const std::string& section) {
    visitOptions(options, [&](const char* key, const auto& value, const char* comment) {
        target.write(section, key, formatValue(value), 24, 12, comment);
    });
}

/// The four sections in order: f(suffix, options).
template <class Options, class F>
void forEachSection(Options& o, F f) {
    f("creationOpts", o.creation);
    f("insertOpts", o.insertion);
    f("likelihoodOpts", o.likelihood);
    f("renderOpts", o.rendering);
}

}  // namespace

void TCreationOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                          const std::string& section) {
    readSection(StrictSection(source, section), section, *this);
}
void TCreationOptions::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                        const std::string& section) const {
    writeSection(*this, target, section);
}
void TCreationOptions::validate() const {
    require(isResolution(resolution), "resolution", resolution, "1e-6 <= resolution <= 1e6");
    require(reserve_megabytes <= kMostMegabytes, "reserve_megabytes", reserve_megabytes,
            "reserve_megabytes <= 1048576");
    require(max_memory_megabytes <= kMostMegabytes, "max_memory_megabytes",
            max_memory_megabytes, "max_memory_megabytes <= 1048576");
    require(max_memory_megabytes == 0 || reserve_megabytes <= max_memory_megabytes,
            "reserve_megabytes", reserve_megabytes,
            "reserve_megabytes <= max_memory_megabytes");
    formatValue(load_from);
    formatValue(lazy_load_path);
    if (!lazy_load_path.empty() && !std::filesystem::is_directory(lazy_load_path))
        throw std::invalid_argument("lazy_load_path = " + shortened(lazy_load_path) +
                                    ": must be a folder that exists");
}

void TInsertionOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                           const std::string& section) {
    readSection(StrictSection(source, section), section, *this);
}
void TInsertionOptions::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                         const std::string& section) const {
    writeSection(*this, target, section);
}
void TInsertionOptions::setPolicy(UpdatePolicy chosen) {
    const auto suited = SensorProbabilities::defaultsOf(chosen);
    policy = chosen;
    probHit = suited.probHit;
    probMiss = suited.probMiss;
    clampingThresMin = suited.clampMin;
    scanHitMax = suited.scanHitMax;
    scanMissMin = suited.scanMissMin;
}
void TInsertionOptions::validate() const {
    sensorModel();
    rangeLimits();
    integratorOptions();
    require(decimation >= 1, "decimation", decimation, "decimation >= 1");
    require(!std::isnan(noReturnRange), "noReturnRange", noReturnRange, "being a number");
    require(std::isfinite(sweepDuration) && sweepDuration >= 0, "sweepDuration", sweepDuration,
            "sweepDuration >= 0");
    require(horizontalTolerance >= 0 && horizontalTolerance <= 90, "horizontalTolerance",
            horizontalTolerance, "0 <= horizontalTolerance <= 90");
    require(heightBandMin < heightBandMax, "heightBandMin", heightBandMin,
            "heightBandMin < heightBandMax");
    require(std::isfinite(windowRadius) && windowRadius >= 0, "windowRadius", windowRadius,
            "windowRadius >= 0");
    formatValue(sensorLabel);
}

SensorModel TInsertionOptions::sensorModel() const {
    return SensorModel(SensorProbabilities{probHit, probMiss, clampingThresMin,
                                           clampingThresMax, occupancyThres, scanHitMax,
                                           scanMissMin});
}

std::string describeRule(const TInsertionOptions& o) {
    std::ostringstream out;
    out << toString(o.policy) << ", hit " << o.probHit << ", miss " << o.probMiss;
    if (o.policy == UpdatePolicy::netEvidence)
        out << ", a scan " << o.scanMissMin << " to " << o.scanHitMax;
    out << ", clamps " << o.clampingThresMin << " to " << o.clampingThresMax;
    return out.str();
}

RangeLimits TInsertionOptions::rangeLimits() const {
    require(!std::isnan(maxrange), "maxrange", maxrange, "being a number");
    require(std::isfinite(minrange) && minrange >= 0, "minrange", minrange, "minrange >= 0");
    RangeLimits limits;
    limits.minimum = minrange;
    if (maxrange > 0) {
        require(minrange < maxrange, "minrange", minrange, "minrange < maxrange");
        limits.maximum = maxrange;
    }
    return limits;
}

IntegratorOptions TInsertionOptions::integratorOptions() const {
    IntegratorOptions options;
    options.method = method;
    options.policy = policy;
    options.superRayThreshold = superRayThreshold;
    options.threads = threads;
    options.validate();
    return options;
}

bool TInsertionOptions::acceptsSensor(const std::string& label) const {
    if (sensorLabel.empty()) return true;
    const auto accepted = splitList(sensorLabel);
    return std::find(accepted.begin(), accepted.end(), label) != accepted.end();
}

void TLikelihoodOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                            const std::string& section) {
    readSection(StrictSection(source, section), section, *this);
}
void TLikelihoodOptions::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                          const std::string& section) const {
    writeSection(*this, target, section);
}
void TLikelihoodOptions::validate() const {
    require(decimation >= 1, "decimation", decimation, "decimation >= 1");
    // Squares of their ratio must stay far from what a double can hold.
    require(sigma >= 1e-6 && sigma <= 1e6, "sigma", sigma, "1e-6 <= sigma <= 1e6");
    require(maxDistance >= 1e-6 && maxDistance <= 1e6, "maxDistance", maxDistance,
            "1e-6 <= maxDistance <= 1e6");
    require(uniformWeight >= 0 && uniformWeight < 1, "uniformWeight", uniformWeight,
            "0 <= uniformWeight < 1");
    require(unknownLikelihood > 0 && unknownLikelihood <= 1, "unknownLikelihood",
            unknownLikelihood, "0 < unknownLikelihood <= 1");
}

void TRenderingOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                           const std::string& section) {
    readSection(StrictSection(source, section), section, *this);
}
void TRenderingOptions::saveToConfigFile(mrpt::config::CConfigFileBase& target,
                                         const std::string& section) const {
    writeSection(*this, target, section);
}

void TMapOptions::validate() const {
    creation.validate();
    insertion.validate();
    likelihood.validate();
}

void TMapOptions::loadFromConfigFile(const mrpt::config::CConfigFileBase& source,
                                     const std::string& prefix) {
    std::vector<std::string> sections, known;
    source.getAllSections(sections);
    forEachSection(*this,
                   [&](const char* suffix, auto&) { known.push_back(prefix + "_" + suffix); });
    for (const auto& s : sections) {
        if (s.size() <= prefix.size() ||
            !equalIgnoringCase(s.substr(0, prefix.size() + 1), prefix + "_"))
            continue;
        bool found = false;
        for (const auto& k : known) found = found || equalIgnoringCase(s, k);
        if (!found)
            throw std::invalid_argument("[" + s + "]: unknown section; did you mean [" +
                                        closestTo(s, known) + "]?");
    }
    TMapOptions updated = *this;
    forEachSection(updated, [&](const char* suffix, auto& options) {
        options.loadFromConfigFile(source, prefix + "_" + suffix);
    });
    *this = updated;
}

std::string TMapOptions::toText() const {
    std::string text;
    forEachSection(*this, [&](const char* suffix, const auto& options) {
        text += "[" + std::string(suffix) + "]\n";
        visitOptions(options, [&](const char* key, const auto& value, const char*) {
            text += std::string(key) + " = " + formatValue(value) + "\n";
        });
    });
    return text;
}

void TMapOptions::fromText(const std::string& text) {
    std::vector<std::pair<std::string, std::vector<StrictSection::Entry>>> sections;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t equals = line.find(" = ");
        if (line.size() > 2 && line.front() == '[' && line.back() == ']') {
            const std::string name = line.substr(1, line.size() - 2);
            for (const auto& section : sections)
                if (section.first == name)
                    throw std::invalid_argument("options: second section [" + shortened(name) +
                                                "]");
            sections.push_back({name, {}});
        } else if (!sections.empty() && equals != std::string::npos) {
            const std::string key = line.substr(0, equals);
            for (const auto& entry : sections.back().second)
                if (entry.key == key)
                    throw std::invalid_argument("options: second key " + shortened(key) +
                                                " in [" + sections.back().first + "]");
            sections.back().second.push_back({key, line.substr(equals + 3), false});
        } else {
            throw std::invalid_argument("options: unexpected line \"" + shortened(line) + "\"");
        }
    }
    TMapOptions updated = *this;
    for (auto& [name, entries] : sections) {
        bool known = false;
        forEachSection(updated,
                       [&, &n = name, &list = entries](const char* suffix, auto& options) {
                           if (n != suffix) return;
                           known = true;
                           readSection(StrictSection(n, std::move(list)), n, options);
                       });
        if (!known)
            throw std::invalid_argument("options: unknown section [" + shortened(name) + "]");
    }
    *this = updated;
}

}  // namespace superray
