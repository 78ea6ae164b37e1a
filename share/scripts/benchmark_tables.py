#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes Markdown tables of what superray-bench wrote.

  benchmark_tables.py RESULT.json... > tables.md
  benchmark_tables.py RESULT.json... --into doc/benchmarks.md

Takes the JSON files of `compare` and `realtime`, in any number. With --into,
replaces what is between the lines `<!-- figures: begin -->` and
`<!-- figures: end -->` of a file.
"""

import argparse
import json
import pathlib
import sys

BEGIN, END = "<!-- figures: begin -->", "<!-- figures: end -->"
METHODS = ("perRay", "superRays", "culling", "full")


def number(value, digits=3):
    """Significant digits, never 1e+03; a dash for nothing."""
    if value is None:
        return "-"
    if value == 0:
        return "0"
    text = f"{value:.{digits}g}"
    return f"{float(text):,.0f}" if abs(value) >= 10 ** (digits - 1) else text


def megabytes(value):
    return number(None if value is None else value / 1e6)


def table(heading, rows):
    lines = ["| " + " | ".join(heading) + " |",
             "|---" + "|---:" * (len(heading) - 1) + "|"]
    lines += ["| " + " | ".join(str(field) for field in row) + " |" for row in rows]
    return "\n".join(lines)


def compared_ms(run):
    """What ratios go by: processor time with one thread, elapsed time with several."""
    return run["cpu_ms_per_scan"] if run["threads"] == 1 else run["ms_per_scan"]


def side_stages(run):
    """Largest share of a stage other than traversal and apply: (percent, name)."""
    stages = run["stage_seconds"]
    if not stages:
        return None, ""
    total = sum(stages.values())
    shares = {name: 100 * s / total for name, s in stages.items()
              if name not in ("traversal", "apply")}
    name = max(shares, key=shares.get)
    return shares[name], name


class Case:
    """All runs of one input at one resolution, of one file."""

    def __init__(self, runs):
        first = runs[0]
        self.name = f"{first['data']} {first['resolution']:g} m"
        self.scans = first["scans"]
        ours = [r["policy"] for r in runs if r["engine"] in ("grid", "octree")]
        self.policy = ours[0] if ours else first["policy"]
        # Of several policies in one run, the first counts; the others stand beside it.
        self.runs, self.others = {}, {}
        for run in runs:
            key = run["engine"], run["threads"]
            if key in self.runs:
                self.others[(*key, run["policy"])] = run
            else:
                self.runs[key] = run

    def has_peers(self):
        return any(engine.startswith("mrpt-") for engine, _ in self.runs)

    def is_grids_alone(self):
        """Our grid and MRPT's, for which no octomap is waited for."""
        return (self.get("mrpt-grid3d") and not self.get("mrpt-octomap") and
                not self.get("octomap"))

    def measures_maps(self):
        """Our maps against octomap, and little else that would compete for memory."""
        ours = [e for e in ("grid", "octree") if self.get(e)]
        return (self.get("octomap") and ours and self.policy == "netEvidence" and
                all(threads == 1 for _, threads in self.runs) and
                (not self.has_peers() or "octree" in ours))

    def get(self, engine, threads=1):
        return self.runs.get((engine, threads))

    def beside_policy(self, policy, engine):
        """Time, that with another policy in the same run, and their ratio; or nothing."""
        other = self.others.get((engine, 1, policy))
        if not other:
            return [None] * 3
        mine, its = self.ms(engine), compared_ms(other)
        return [mine, its, mine / its]

    def ms(self, engine, threads=1):
        run = self.get(engine, threads)
        return compared_ms(run) if run else None

    def ratio(self, engine, threads=1):
        run = self.get(engine, threads)
        return run["ratio_to_octomap"] if run else None

    def bytes(self, engine):
        run = self.get(engine)
        return run["map_bytes"] if run else None

    def share_of_octomap(self, engine):
        mine, base = self.bytes(engine), self.bytes("octomap")
        return mine / base if mine and base else None

    def times(self, engine, faster):
        a, b = self.ms(engine), self.ms(faster)
        return a / b if a and b else None

    def best_method(self, engine):
        """Time of the automatic choice over that of the best single method."""
        times = [self.ms(f"{engine}-{m}") for m in METHODS if self.get(f"{engine}-{m}")]
        mine = self.ms(engine)
        return mine / min(times) if mine and times else None


def cases_of(documents):
    cases = []
    for document in documents:
        groups = {}
        for run in document["runs"]:
            groups.setdefault((run["data"], run["resolution"]), []).append(run)
        cases += [Case(runs) for runs in groups.values()]
    return cases


def compare_tables(documents):
    cases = cases_of(documents)
    one = [c for c in cases if c.measures_maps()]
    grids = [c for c in cases if c.is_grids_alone()]
    beside = [c for c in cases if c.has_peers() and not c.is_grids_alone()]
    two = [c for c in cases if c.get("grid", 2) or c.get("octree", 2)]
    once = [c for c in cases if c.policy == "oncePerScan"]
    paper = [c for c in cases if any(policy == "everyRay" for _, _, policy in c.others)]
    out = []
    if one:
        maps = ["octomap", "octomap-rays", "grid", "octree"]
        out += ["### Time per scan [ms], one thread",
                table(["data", "scans"] + maps,
                      [[c.name, c.scans] + [number(c.ms(e)) for e in maps] for c in one]),
                "### Times faster than octomap, one thread",
                table(["data"] + maps[1:],
                      [[c.name] + [number(c.ratio(e)) for e in maps[1:]] for c in one])]
    if paper:
        names = ["netEvidence", "everyRay", "ratio"]
        out += ["### The default policy beside the paper's, in one run: time per scan [ms]",
                table(["data"] + [f"{e} {n}" for e in ("grid", "octree") for n in names],
                      [[c.name] + [number(v) for e in ("grid", "octree")
                                   for v in c.beside_policy("everyRay", e)] for c in paper])]
    if grids:
        pair = ["mrpt-grid3d", "grid"]
        out += ["### Beside MRPT's COccupancyGridMap3D: time per scan [ms], one thread",
                table(["data", "scans"] + pair + ["times"] + [f"{e} MB" for e in pair],
                      [[c.name, c.scans] + [number(c.ms(e)) for e in pair] +
                       [number(c.times(*pair))] +
                       [megabytes(c.bytes(e)) for e in pair] for c in grids])]
    if beside:
        peers = ["octomap", "mrpt-octomap", "mrpt-grid3d", "grid"]
        out += ["### Beside MRPT's maps: time per scan [ms], one thread; map memory [MB]",
                table(["data", "scans"] + peers + ["mrpt-grid3d / grid"] +
                      [f"{e} MB" for e in peers],
                      [[c.name, c.scans] + [number(c.ms(e)) for e in peers] +
                       [number(c.times("mrpt-grid3d", "grid"))] +
                       [megabytes(c.bytes(e)) for e in peers] for c in beside])]
    for engine in ("grid", "octree"):
        methods = [c for c in cases if c.best_method(engine)]
        if methods:
            names = [engine] + [f"{engine}-{m}" for m in METHODS]
            out += [f"### Methods on the {engine}: time per scan [ms], one thread",
                    table(["data"] + ["auto"] + list(METHODS) + ["auto / best"],
                          [[c.name] + [number(c.ms(n)) for n in names] +
                           [number(c.best_method(engine))] for c in methods])]
    if one:
        rows = []
        for c in one:
            for engine in ("grid", "octree"):
                run = c.get(engine)
                if not run or not run["stage_seconds"]:
                    continue
                total = sum(run["stage_seconds"].values())
                share, name = side_stages(run)
                rows.append([c.name, engine] +
                            [f"{100 * s / total:.0f}" for s in run["stage_seconds"].values()] +
                            [f"{share:.0f} ({name.replace('_', ' ')})"])
        stages = ["points to rays", "super rays", "culling region", "traversal", "apply",
                  "other", "largest but traversal, apply"]
        out += ["### Time by stage [%]", table(["data", "map"] + stages, rows),
                "### Map memory [MB], and as a share of octomap's",
                table(["data"] + maps + ["grid / octomap", "octree / octomap"],
                      [[c.name] + [megabytes(c.bytes(e)) for e in maps] +
                       [number(c.share_of_octomap(e)) for e in ("grid", "octree")]
                       for c in one])]
        if any(r["peak_bytes"] for c in one for r in c.runs.values()):
            out += ["### Largest growth of the process [MB]",
                    table(["data"] + maps,
                          [[c.name] + [megabytes((c.get(e) or {}).get("peak_bytes"))
                                       for e in maps] for c in one])]
    if two:
        rows = []
        for c in two:
            row = [c.name]
            for engine in ("grid", "octree"):
                single, double = c.get(engine), c.get(engine, 2)
                if not single or not double:
                    row += ["-"] * 5
                    continue
                copies = c.get(f"{engine}-copies", 2)
                row += [number(single["ms_per_scan"]), number(double["ms_per_scan"]),
                        number(single["ms_per_scan"] / double["ms_per_scan"]),
                        number(2 * single["ms_per_scan"] / copies["ms_per_scan"])
                        if copies else "-",
                        "yes" if single["digest"] == double["digest"] else "NO"]
            rows.append(row)
        columns = ["1 thread", "2 threads", "times", "of two maps at once", "same map"]
        out += ["### Two threads: elapsed time per scan [ms]",
                table(["data"] + [f"{e} {c}" for e in ("grid", "octree") for c in columns],
                      rows)]
    if once:
        rows = []
        for c in once:
            octomap, grid = c.get("octomap"), c.get("grid")
            same = octomap and octomap["digest"] == grid["digest"]
            rows.append([c.name, number(c.ratio("grid")), number(c.ratio("octree")),
                         "yes" if same else "no"])
        out += ["### Policy oncePerScan: times faster than octomap",
                table(["data", "grid", "octree", "map equals octomap's, bit for bit"], rows)]
    return out


def realtime_tables(documents):
    rows = []
    for document in documents:
        for r in document["runs"]:
            rows.append([pathlib.Path(r["data"]).stem, f"{r['rate']:g}", f"{r['resolution']:g}",
                         "all" if r["all_points"] else "80 %", r["engine"], r["threads"],
                         r["scans_used"], r["scans_lost"], number(r["mean_ms"]),
                         number(r["max_ms"]), f"{100 * r['accuracy']:.1f}"])
    if not rows:
        return []
    return ["### At the sensor's rate",
            table(["data", "Hz", "m", "points", "engine", "threads", "used", "lost", "mean ms",
                   "max ms", "accuracy %"], rows)]


def replace_section(path, text):
    lines = path.read_text().splitlines()
    if lines.count(BEGIN) != 1 or lines.count(END) != 1:
        sys.exit(f"error: {path} must have one line '{BEGIN}' and one '{END}'")
    begin, end = lines.index(BEGIN), lines.index(END)
    path.write_text("\n".join(lines[:begin + 1] + ["", text, ""] + lines[end:]) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="+", type=pathlib.Path, metavar="RESULT.json")
    parser.add_argument("--into", type=pathlib.Path, metavar="FILE.md")
    arguments = parser.parse_args()
    documents = {"compare": [], "realtime": []}
    for path in arguments.results:
        try:
            document = json.loads(path.read_text())
            kind = document["program"].split()[-1]
            documents[kind].append(document)
        except (OSError, ValueError, KeyError, AttributeError, TypeError) as error:
            sys.exit(f"error: {path} is not a result of superray-bench: {error!r}")
    text = "\n\n".join(compare_tables(documents["compare"]) +
                       realtime_tables(documents["realtime"]))
    if arguments.into:
        replace_section(arguments.into, text)
    else:
        print(text)


if __name__ == "__main__":
    main()
