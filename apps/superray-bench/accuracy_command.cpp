// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/accuracy.h>
#include <superray/eval/input_error.h>
#include <superray/eval/output_paths.h>
#include <superray/maps/png_output.h>

#include <iostream>
#include <memory>

#include "commands.h"
#include "input_options.h"

namespace superray {
namespace {

constexpr char kProtocol[] =
    R"(
Any data. 20 % of the points of every scan (seeded) are held out: their end points
should be occupied (p > 0.7), and one point drawn along each of their rays, at
least two cells before its end, free (p < 0.3). Unknown is wrong. Maps are made
of the other points of all scans. "at 0.5" is the same with one threshold; AUC
the chance that an occupied point has a larger p than a free one; the ceiling
what the best label of each cell would have right.

Simulated worlds, besides: cells against the exact geometry, occupied from p =
0.5 on. IoU = kept / (kept + false + missed); kept: said occupied, contains
solid; false: said occupied, contains none; missed: an exact ray ends in it, not
said occupied. Complete points, cells: exact end points whose cell is said
occupied, and the cells in which they lie. Free
said occupied: false / known cells without solid.

World 'walker': detected, rays to the walker, and the cells in which they ended for
the first time, of which the map says occupied right after that scan; t50, scans until half of the cells of a box that
was taken away are not said occupied any more; ghosts, cells said occupied at the
end where the walker was and is not.

Our maps run once for each policy, each with its own probabilities; other engines
with 0.7 / 0.4 and clamps 0.1192 / 0.971 (shared), and with their defaults (own).
Engines may make something else of these: what rays really do is found by
inserting some, and printed.

Pictures show a layer of the maps over the truth: black kept, red missing, yellow
false, white free. Of recordings, test points tell the truth.

Examples:
  superray-bench accuracy indoor outdoor --resolutions 0.2,0.4 --figures out.json
  superray-bench accuracy drive.rawlog --poses drive.tum --picture street.png
  superray-bench accuracy indoor --pose-noise 0.03,0.17 --engines grid,octomap
  superray-bench accuracy outdoor --engines grid --policies netEvidence \
      --scan-miss-min 0.293,0.4 --seed 7
  superray-bench accuracy walker
)";

struct Arguments {
    AccuracyRequest request;
    std::vector<std::string> policies, models;
    std::vector<double> poseNoise, slice;
    FigureOptions figures;
    std::string picture;
};

/// The two values of an option that must have two.
void checkPair(const std::string& option, const std::vector<double>& values) {
    if (values.size() != 2)
        throw InputError(option + " needs two numbers separated by a comma, got " +
                         std::to_string(values.size()));
}

void finish(Arguments& a) {
    AccuracyRequest& r = a.request;
    finishInputOptions(r.source);
    if (!a.policies.empty()) r.policies.clear();
    for (const std::string& name : a.policies)
        r.policies.push_back(updatePolicyFromString(name));
    if (!a.models.empty()) r.peerModels.clear();
    for (const std::string& name : a.models) r.peerModels.push_back(peerModelFromString(name));
    if (!a.poseNoise.empty()) {
        checkPair("--pose-noise", a.poseNoise);
        r.poseNoise = {a.poseNoise[0], a.poseNoise[1]};
    }
    if (!a.slice.empty()) {
        checkPair("--slice", a.slice);
        r.slice = Slice{a.slice[0], a.slice[1]};
    }
    checkFigureOptions(a.figures, r.data);
    if (a.picture.empty()) return;
    checkOutputPath(a.picture, {".png"});
    r.pictures = true;
    if (r.data.size() != 1 || r.resolutions.size() != 1)
        throw InputError("--picture is for one DATA at one resolution");
    if (r.data.front() == "walker")
        throw InputError("--picture is not for the world walker, which changes");
}

int accuracy(Arguments& a) {
    finish(a);
    const auto tables = runAccuracy(a.request, std::cerr, progressStyle());
    putFigures(a.figures, accuracyAsText(a.request, tables), accuracyAsJson(a.request, tables));
    if (!a.picture.empty()) writePng(*tables.front().picture, a.picture);
    return kSuccess;
}

}  // namespace

Command declareAccuracy(CLI::App& app) {
    auto arguments = std::make_shared<Arguments>();
    auto& a = *arguments;
    AccuracyRequest& r = a.request;
    app.footer(kDataHelp + std::string("\n") + enginesHelp() + kProtocol);
    app.add_option("DATA", r.data, "Scans")->required()->type_name("DATA");
    addListOption(app, "--resolutions", r.resolutions, "Cell edges; default 0.2", "METRES");
    addListOption(app, "--engines", r.engines, "Default: grid,octomap,mrpt-grid3d", "NAMES");
    addListOption(app, "--policies", a.policies,
                  "Of our maps; default netEvidence,everyRay,oncePerScan", "NAMES");
    addListOption(app, "--models", a.models, "Of other engines; default shared,own", "NAMES");
    addListOption(app, "--scan-miss-min", r.scanMissMins,
                  "Of netEvidence, one row each; default 0.293", "P");
    app.add_option("--threads", r.threads, "Of our maps; default 1")->type_name("N");
    addListOption(app, "--pose-noise", a.poseNoise,
                  "Sigmas of the error of each scan's pose; default 0,0", "METRES,DEGREES");
    app.add_option("--test-seed", r.testSeed,
                   "Choice of test points, and pose noise; default 1")
        ->type_name("N");
    addInputOptions(app, r.source, r.worldSeed);
    addFigureOptions(app, a.figures);
    auto* picture =
        app.add_option("--picture", a.picture, "Draw the maps over the truth (.png)")
            ->type_name("OUTPUT");
    addListOption(app, "--slice", a.slice,
                  "Heights that the picture shows; default: one layer of cells, 0.5 m below "
                  "the sensor of the first scan",
                  "LOW,HIGH")
        ->needs(picture);
    return [arguments] { return accuracy(*arguments); };
}

}  // namespace superray
