# SPDX-License-Identifier: BSD-3-Clause
"""Stock observations2map builds all four map classes when the plugin is preloaded."""

import unittest

from programs import PLUGIN_MESSAGE, ProgramTest

ALIASES = {
    "CSuperRayGridMap3D": "superRayGridMap3D",
    "CSuperRayOctoMap": "superRayOctoMap",
    "CSuperRayGridMap2D": "superRayGridMap2D",
    "CSuperRayQuadMap": "superRayQuadMap",
}


class Observations2Map(ProgramTest):
    def write_config(self, policy):
        """One map of each class, with options unlike the defaults."""
        text = "[MappingApplication]\n"
        for alias in ALIASES.values():
            text += f"{alias}_count = 1\n"
        for alias in ALIASES.values():
            text += (f"[MappingApplication_{alias}_00_creationOpts]\nresolution = 0.07\n"
                     f"[MappingApplication_{alias}_00_insertOpts]\n"
                     f"policy = {policy}\nmaxrange = 6\nprobHit = 0.8\n")
        path = self.folder / f"{policy}.ini"
        path.write_text(text)
        return path

    def check_all_classes(self, policy):
        config = self.write_config(policy)
        simplemap = self.dataset("localization_demo.simplemap.gz")
        _, log = self.run_program("observations2map", config, simplemap, "out", preload=True)
        self.assertIn(PLUGIN_MESSAGE, log)
        digests = {}
        for name, alias in ALIASES.items():
            maps = list(self.folder.glob(f"out_superray__{name}_*.srmap"))
            self.assertEqual(len(maps), 1, name)
            info = self.info(maps[0])
            self.assertEqual(info["class"], name)
            self.assertAlmostEqual(info["resolution"], 0.07)
            self.assertGreater(info["cells"]["occupied"], 200)
            self.assertGreater(info["cells"]["free"], 5000)
            rebuilt = self.build_map(simplemap, "--config", config, "--section",
                                     f"MappingApplication_{alias}_00", "--map", name)
            self.assertEqual(self.info(rebuilt)["class"], name)
            digests[name] = self.digest(maps[0])
            self.assertEqual(digests[name], self.digest(rebuilt), name)
            if "3D" in name or "Octo" in name:
                self.run_program(self.superray_map, "compare", maps[0],
                                 maps[0].with_suffix(".ot"))
            else:
                self.assertGreater(maps[0].with_suffix(".png").stat().st_size, 500)
        self.assertEqual(digests["CSuperRayGridMap3D"], digests["CSuperRayOctoMap"])
        self.assertEqual(digests["CSuperRayGridMap2D"], digests["CSuperRayQuadMap"])
        self.assertNotEqual(digests["CSuperRayGridMap2D"], digests["CSuperRayGridMap3D"])
        return digests

    def test_every_class_equals_superray_map_build(self):
        every_ray = self.check_all_classes("everyRay")
        once_per_scan = self.check_all_classes("oncePerScan")
        for name in ALIASES:
            self.assertNotEqual(every_ray[name], once_per_scan[name], name)

    def test_without_the_plugin_there_are_no_such_maps(self):
        simplemap = self.dataset("localization_demo.simplemap.gz")
        self.run_without_plugin("observations2map", self.write_config("everyRay"), simplemap,
                                "out")
        self.assertEqual(list(self.folder.glob("out*")), [])


if __name__ == "__main__":
    unittest.main()
