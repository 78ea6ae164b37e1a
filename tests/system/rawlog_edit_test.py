"""Stock rawlog-edit loads the plugin with -p, works, and exits cleanly."""

import unittest

from programs import PLUGIN_MESSAGE, ProgramTest


class RawlogEdit(ProgramTest):
    def test_info(self):
        rawlog = self.dataset("tests_rgbd.rawlog")
        plain, errors = self.run_program("rawlog-edit", "--info", "-i", rawlog)
        self.assertNotIn(PLUGIN_MESSAGE, errors)
        loaded, errors = self.run_program("rawlog-edit", "-p", self.plugin, "--info", "-i", rawlog)
        self.assertIn(PLUGIN_MESSAGE, errors)
        for line in plain.splitlines():
            if "number of objects" in line or "labels" in line:
                self.assertIn(line, loaded)
        self.assertIn("OPENNI2", loaded)

    def test_map_of_a_rewritten_rawlog_is_the_same(self):
        rawlog = self.dataset("localization_demo.rawlog")
        copy = self.folder / "copy.rawlog"
        _, log = self.run_program("rawlog-edit", "-p", self.plugin, "--cut", "--from-index", "0",
                                  "-i", rawlog, "-o", copy)
        self.assertIn(PLUGIN_MESSAGE, log)
        options = ["--map", "CSuperRayGridMap2D"]
        original = self.build_map(rawlog, *options)
        self.assertGreater(self.info(original)["cells"]["occupied"], 100)
        self.assertEqual(self.digest(original), self.digest(self.build_map(copy, *options)))


if __name__ == "__main__":
    unittest.main()
