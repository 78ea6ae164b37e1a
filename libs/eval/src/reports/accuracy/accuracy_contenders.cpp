// SPDX-License-Identifier: BSD-3-Clause
#include "reports/accuracy/accuracy_contenders.h"

#include <superray/eval/engine_weights.h>

#include "text/text_table.h"

namespace superray {
namespace {

bool isPeer(const BenchEngineInfo& info) {
    return !info.ownPolicy.empty();
}

void addOurs(const AccuracyRequest& request, Contender contender,
             std::vector<Contender>& contenders) {
    const auto add = [&] {
        contender.row.weights = describe(weightsOf(*contender.info, contender.options));
        contenders.push_back(contender);
    };
    for (const UpdatePolicy policy : request.policies) {
        contender.options.policy = policy;
        contender.row.policy = toString(policy);
        contender.row.model = "-";
        if (policy != UpdatePolicy::netEvidence || request.scanMissMins.empty()) {
            contender.options.scanMissMin.reset();
            add();
            continue;
        }
        for (const double scanMissMin : request.scanMissMins) {
            contender.options.scanMissMin = scanMissMin;
            std::string digits = formatFixed(scanMissMin, 3);
            digits.erase(digits.find_last_not_of('0') + 1);
            contender.row.policy = toString(policy) + (" " + digits);
            add();
        }
    }
}

/// A row for each sensor model, but one if they come to the same.
void addPeer(const AccuracyRequest& request, Contender contender,
             std::vector<Contender>& contenders) {
    contender.row.policy = contender.info->ownPolicy;
    std::optional<EngineWeights> before;
    for (const PeerModel model : request.peerModels) {
        contender.options.peerModel = model;
        const EngineWeights weights = weightsOf(*contender.info, contender.options);
        if (before && sameWeights(*before, weights)) {
            contenders.back().row.model += std::string(" = ") + toString(model);
            continue;
        }
        before = weights;
        contender.row.model = toString(model);
        contender.row.weights = describe(weights);
        contenders.push_back(contender);
    }
}

}  // namespace

std::vector<Contender> contendersOf(const AccuracyRequest& request, double resolution,
                                    const Eigen::AlignedBox3f& bounds) {
    std::vector<Contender> contenders;
    for (const std::string& name : request.engines) {
        Contender contender{&benchEngine(name), {}, {}};
        contender.options.resolution = resolution;
        contender.options.threads = request.threads;
        contender.options.bounds = bounds;
        contender.row.engine = name;
        (isPeer(*contender.info) ? addPeer : addOurs)(request, contender, contenders);
    }
    return contenders;
}

}  // namespace superray
