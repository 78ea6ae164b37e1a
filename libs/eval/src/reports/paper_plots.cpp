// SPDX-License-Identifier: BSD-3-Clause
#include <superray/eval/paper_figures.h>

#include <functional>
#include <map>
#include <set>
#include <sstream>

namespace superray {
namespace {

struct Series {
    std::string title;
    std::vector<std::pair<double, double>> points;
};

/// In gnuplot's single quotes.
std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("''") : std::string{c};
    return result + "'";
}

std::string header(const std::string& name, const std::string& title) {
    return "# gnuplot " + name + ".gp draws " + name +
           ".png\n"
           "set terminal pngcairo size 1000,650 noenhanced font 'sans,11'\n"
           "set output " +
           quoted(name + ".png") + "\nset title " + quoted(title) +
           "\nset key outside right\nset grid\n";
}

NamedText linePlot(const std::string& name, const std::string& title,
                   const std::string& settings, const std::vector<Series>& all) {
    std::ostringstream out;
    out << header(name, title) << settings;
    std::string plot;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].points.empty()) continue;
        out << "$d" << i << " << EOD\n";
        for (const auto& [x, y] : all[i].points) out << x << " " << y << "\n";
        out << "EOD\n";
        plot += (plot.empty() ? "plot " : ", \\\n     ") + std::string("$d") +
                std::to_string(i) + " with linespoints linewidth 2 title " +
                quoted(all[i].title);
    }
    if (plot.empty()) return {};
    return {name + ".gp", out.str() + plot + "\n"};
}

std::string titleOf(const BenchRun& run) {
    return run.threads == 1 ? run.engine
                            : run.engine + ", " + std::to_string(run.threads) + " threads";
}

/// A series for each engine and number of threads.
using AddPoints = std::function<void(const BenchRun&, Series&)>;
std::vector<Series> seriesOf(const std::vector<BenchRun>& runs, const AddPoints& add) {
    std::vector<Series> all;
    for (const BenchRun& run : runs) {
        const std::string title = titleOf(run);
        Series* series = nullptr;
        for (Series& s : all)
            if (s.title == title) series = &s;
        if (series == nullptr) series = &all.emplace_back(Series{title, {}});
        add(run, *series);
    }
    return all;
}

std::string metres(double resolution) {
    std::ostringstream text;
    text << resolution;
    return text.str();
}

std::vector<BenchRun> atResolution(const std::vector<BenchRun>& runs, double resolution) {
    std::vector<BenchRun> result;
    for (const BenchRun& run : runs)
        if (run.resolution == resolution) result.push_back(run);
    return result;
}

/// Bars of stages, one for each engine that tells them.
NamedText stagePlot(const std::vector<BenchRun>& runs, double resolution) {
    const std::string name = "fig12_stages_" + metres(resolution);
    std::ostringstream out;
    out << header(name, "Time by stage, " + metres(resolution) + " m")
        << "set style data histograms\nset style histogram rowstacked\n"
           "set style fill solid 0.8 border -1\nset boxwidth 0.7\n"
           "set ylabel 'ms per scan'\nset xtics rotate by -35\n$d << EOD\n"
           "engine rays superrays culling traversal apply\n";
    int bars = 0;
    for (const BenchRun& run : atResolution(runs, resolution)) {
        const BenchWork& w = run.work;
        if (w.toRaysSeconds == 0) continue;
        ++bars;
        out << '"' << titleOf(run) << '"';
        for (const double s : {w.toRaysSeconds, w.superRaySeconds, w.cullingSeconds,
                               w.traversalSeconds, w.applySeconds})
            out << " " << 1e3 * s / static_cast<double>(run.scans);
        out << "\n";
    }
    if (bars == 0) return {};
    out << "EOD\nplot $d using 2:xtic(1) title 'points to rays', '' using 3 title 'super "
           "rays', "
           "'' using 4 title 'culling region', '' using 5 title 'traversal', "
           "'' using 6 title 'apply'\n";
    return {name + ".gp", out.str()};
}

}  // namespace

std::vector<NamedText> paperPlots(const PaperRuns& all) {
    const auto& runs = all.compared;
    std::vector<NamedText> plots;
    const auto add = [&](NamedText plot) {
        if (!plot.name.empty()) plots.push_back(std::move(plot));
    };
    add(linePlot("fig10_speedup", "Speed-up over octomap",
                 "set xlabel 'resolution [m]'\nset ylabel 'times'\nset logscale y\n",
                 seriesOf(runs, [](const BenchRun& r, Series& s) {
                     if (r.ratioToOctomap && r.engine != "octomap")
                         s.points.emplace_back(r.resolution, *r.ratioToOctomap);
                 })));
    std::set<double> resolutions;
    for (const BenchRun& run : runs) resolutions.insert(run.resolution);
    for (const double resolution : resolutions) {
        std::vector<Series> overK;
        std::map<std::string, std::size_t> index;
        for (const auto& [k, runsAtK] : all.overThreshold)
            for (const BenchRun& r : atResolution(runsAtK, resolution)) {
                const auto [at, isNew] = index.emplace(titleOf(r), overK.size());
                if (isNew) overK.push_back({titleOf(r), {}});
                overK[at->second].points.emplace_back(k, meanOf(comparedMs(r)));
            }
        add(linePlot("fig11_threshold_" + metres(resolution),
                     "Threshold k, " + metres(resolution) + " m",
                     "set xlabel 'k'\nset ylabel 'ms per scan'\nset logscale x\n"
                     "set yrange [0:*]\n",
                     overK));
        add(stagePlot(runs, resolution));
        add(linePlot("fig15_scans_" + metres(resolution),
                     "Update of each scan, " + metres(resolution) + " m",
                     "set xlabel 'scan'\nset ylabel 'ms'\nset logscale y\n",
                     seriesOf(atResolution(runs, resolution), [](const BenchRun& r, Series& s) {
                         for (std::size_t i = 0; i < comparedMs(r).size(); ++i)
                             s.points.emplace_back(static_cast<double>(i), comparedMs(r)[i]);
                     })));
    }
    return plots;
}

}  // namespace superray
