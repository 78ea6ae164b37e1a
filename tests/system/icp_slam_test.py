"""Stock icp-slam builds our maps when the plugin is preloaded."""

import unittest

from programs import PLUGIN_MESSAGE, ProgramTest

RAWLOG = "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"

# The maps of icp-slam-superray.ini.
CONFIGURED = {"CSuperRayOctoMap": "superRayOctoMap", "CSuperRayGridMap2D": "superRayGridMap2D"}


class IcpSlam(ProgramTest):
    def setUp(self):
        super().setUp()
        self.config = self.source / "share/config_files/icp-slam-superray.ini"

    def slam(self, preload):
        _, log = self.run_program("icp-slam", self.config, self.dataset(RAWLOG), preload=preload)
        simplemaps = list(self.folder.glob("*/_finalmap_.simplemap"))
        self.assertEqual(len(simplemaps), 1, log[-2000:])
        return log, simplemaps[0]

    def test_maps_equal_those_built_from_the_same_keyframes(self):
        log, simplemap = self.slam(preload=True)
        self.assertIn(PLUGIN_MESSAGE, log)
        for name, alias in CONFIGURED.items():
            maps = list(simplemap.parent.glob(f"*superray__{name}_*.srmap"))
            self.assertEqual(len(maps), 1, name)
            info = self.info(maps[0])
            self.assertEqual(info["class"], name)
            self.assertGreater(info["cells"]["occupied"], 500)
            self.assertGreater(info["cells"]["free"], 10 * info["cells"]["occupied"])
            self.assertGreater(maps[0].with_suffix(".3Dscene").stat().st_size, 1000)

            # icp-slam's keyframes are the scans that it inserted, at their poses.
            rebuilt = self.build_map(simplemap, "--map", name, "--config", self.config,
                                     "--section", f"MappingApplication_{alias}_00")
            self.assertEqual(self.digest(maps[0]), self.digest(rebuilt), name)
            if name == "CSuperRayOctoMap":
                self.run_program(self.superray_map, "compare", maps[0],
                                 maps[0].with_suffix(".ot"))

    def test_without_the_plugin_there_is_no_such_map(self):
        """Stock MRPT 2.5 ignores map names that it does not know."""
        log, simplemap = self.slam(preload=False)
        self.assertNotIn(PLUGIN_MESSAGE, log)
        self.assertEqual(list(simplemap.parent.glob("*superray*")), [])


if __name__ == "__main__":
    unittest.main()
