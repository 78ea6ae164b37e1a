# SPDX-License-Identifier: BSD-3-Clause
"""benchmark_tables.py makes tables of what superray-bench wrote."""

import json
import subprocess
import sys
import unittest

from programs import ProgramTest, path_from_environment


class BenchmarkTables(ProgramTest):
    def setUp(self):
        super().setUp()
        self.bench = path_from_environment("SUPERRAY_BENCH")
        self.script = self.source / "share/scripts/benchmark_tables.py"

    def bench_json(self, name, *arguments):
        path = self.folder / name
        self.run_program(self.bench, *arguments, "--scans", "1", "--figures", path)
        return path

    def tables(self, *arguments):
        text, _ = self.run_program(sys.executable, self.script, *arguments)
        return text

    def test_figures_are_those_of_the_json(self):
        engines = "octomap,mrpt-grid3d," + ",".join(
            m + s for m in ("grid", "octree") for s in ("", "-perRay", "-culling"))
        one = self.bench_json("one.json", "compare", "indoor", "--resolutions", "0.4",
                              "--engines", engines)
        two = self.bench_json("two.json", "compare", "indoor", "--resolutions", "0.4",
                              "--engines", "grid,octree,grid-copies", "--threads", "1,2")
        real = self.bench_json("real.json", "realtime", "indoor", "--resolution", "0.4",
                               "--engines", "grid")
        document = json.loads(one.read_text())
        for run in document["runs"]:  # figures that can be told
            run["cpu_ms_per_scan"] = {"octomap": 500, "grid": 10, "grid-perRay": 20,
                                      "grid-culling": 12.5}.get(run["engine"], 40)
            run["ratio_to_octomap"] = 500 / run["cpu_ms_per_scan"]
        one.write_text(json.dumps(document))
        document = json.loads(two.read_text())
        for run in document["runs"]:
            run["ms_per_scan"] = {"grid": 30, "octree": 40, "grid-copies": 20}[
                run["engine"]] * (1 if run["threads"] == 1 else 2 if "copies" in
                                  run["engine"] else 0.5)
        two.write_text(json.dumps(document))
        text = self.tables(one, two, real)
        lines = text.splitlines()
        self.assertIn("| indoor 0.4 m | 1 | 500 | - | 10 | 40 |", lines)
        self.assertIn("| indoor 0.4 m | - | 50 | 12.5 |", lines)
        self.assertTrue(any(line.startswith("| indoor 0.4 m | 1 | 500 | - | 40 | 10 | 4 |")
                            for line in lines))
        self.assertIn("| indoor 0.4 m | 10 | 20 | - | 12.5 | - | 0.8 |", lines)
        self.assertIn("### Two threads: elapsed time per scan [ms]", lines)
        self.assertEqual(sum("| yes |" in line for line in lines), 1)
        self.assertIn("| indoor 0.4 m | 30 | 15 | 2 | 1.5 | yes | 40 | 20 | 2 | - | yes |",
                      lines)
        self.assertTrue(any(line.startswith("| indoor | 10 | 0.4 | 80 % | grid |")
                            for line in lines))
        for line in lines:
            if line.startswith("| ") and "---" not in line:
                self.assertGreater(line.count("|"), 4)

    def timed_json(self, cpu_ms):
        """Results of the engines, whose times can be told: {engine: ms}."""
        result = self.bench_json("a.json", "compare", "indoor", "--resolutions", "0.4",
                                 "--engines", ",".join(cpu_ms))
        document = json.loads(result.read_text())
        for run in document["runs"]:
            run["cpu_ms_per_scan"] = cpu_ms[run["engine"]]
        result.write_text(json.dumps(document))
        return result

    def test_the_grid_beside_mrpts_grid_alone(self):
        result = self.timed_json({"mrpt-grid3d": 30, "grid": 20})
        lines = self.tables(result).splitlines()
        self.assertIn("### Beside MRPT's COccupancyGridMap3D: time per scan [ms], one thread",
                      lines)
        self.assertTrue(any(line.startswith("| indoor 0.4 m | 1 | 30 | 20 | 1.5 |")
                            for line in lines))

    def test_the_papers_policy_stands_beside_the_default(self):
        result = self.bench_json("a.json", "compare", "indoor", "--resolutions", "0.4",
                                 "--engines", "octomap,grid,octree", "--policies",
                                 "netEvidence,everyRay")
        document = json.loads(result.read_text())
        times = {("octomap", "oncePerScan"): 100, ("grid", "netEvidence"): 12,
                 ("grid", "everyRay"): 10, ("octree", "netEvidence"): 21,
                 ("octree", "everyRay"): 20}
        self.assertEqual(len(document["runs"]), len(times))
        for run in document["runs"]:
            run["cpu_ms_per_scan"] = times[run["engine"], run["policy"]]
        result.write_text(json.dumps(document))
        lines = self.tables(result).splitlines()
        self.assertIn("| indoor 0.4 m | 1 | 100 | - | 12 | 21 |", lines)
        self.assertIn("| indoor 0.4 m | 12 | 10 | 1.2 | 21 | 20 | 1.05 |", lines)

    def test_mrpts_octomap_needs_no_octomap(self):
        result = self.timed_json({"mrpt-octomap": 30, "grid": 20})
        self.assertTrue(any(line.startswith("| indoor 0.4 m | 1 | - | 30 | - | 20 | - |")
                            for line in self.tables(result).splitlines()))

    def test_replaces_the_section_of_a_document(self):
        result = self.bench_json("a.json", "compare", "indoor", "--resolutions", "0.4",
                                 "--engines", "octomap,grid,grid-perRay")
        document = self.folder / "doc.md"
        text = (self.source / "doc/benchmarks.md").read_text()
        document.write_text(text)
        self.tables(result, "--into", document)
        replaced = document.read_text()
        begin = text.index("<!-- figures: begin -->")
        self.assertEqual(replaced[:begin], text[:begin])
        self.assertIn("### Times faster than octomap", replaced[begin:])
        self.assertTrue(replaced.endswith("\n<!-- figures: end -->\n"))

    def test_refuses_other_files(self):
        other = self.folder / "other.json"
        for content in ("no json", "[]", "{}", '{"program": "sh"}'):
            other.write_text(content)
            done = subprocess.run([sys.executable, self.script, other], capture_output=True,
                                  text=True)
            self.assertEqual(done.returncode, 1, content)
            self.assertIn("other.json", done.stderr)


if __name__ == "__main__":
    unittest.main()
