# SPDX-License-Identifier: BSD-3-Clause
"""Stock icp-slam builds our maps when the plugin is preloaded."""

import unittest

from programs import PLUGIN_MESSAGE, ProgramTest, decompressed
from simulated_drive import distance, read_path

RAWLOG = "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"

# The maps of icp-slam-superray.ini.
CONFIGURED = {"CSuperRayOctoMap": "superRayOctoMap", "CSuperRayGridMap2D": "superRayGridMap2D"}


class IcpSlam(ProgramTest):
    def slam(self):
        _, log = self.run_as_documented("icp-slam", "icp-slam-superray.ini",
                                        self.dataset(RAWLOG))
        simplemaps = list(self.folder.glob("*/_finalmap_.simplemap"))
        self.assertEqual(len(simplemaps), 1, log[-2000:])
        return log, simplemaps[0]

    def test_maps_equal_those_built_from_the_same_keyframes(self):
        log, simplemap = self.slam()
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
            rebuilt = self.build_map(simplemap, "--map", name, "--config",
                                     self.config("icp-slam-superray.ini"),
                                     "--section", f"MappingApplication_{alias}_00")
            self.assertEqual(self.digest(maps[0]), self.digest(rebuilt), name)
            if name == "CSuperRayOctoMap":
                self.run_program(self.superray_map, "compare", maps[0],
                                 maps[0].with_suffix(".ot"))

    def test_without_the_plugin_there_is_no_such_map(self):
        """Stock MRPT ignores map names that it does not know, or refuses them."""
        done = self.run_without_plugin("icp-slam", self.config("icp-slam-superray.ini"),
                                       self.dataset(RAWLOG))
        if done:
            self.assertEqual(len(list(self.folder.glob("*/_finalmap_.simplemap"))), 1)
        self.assertEqual(list(self.folder.glob("*/*superray__*")), [])


class SoleReference(ProgramTest):
    """Our points map is the only map: what ICP aligns the laser to."""

    def setUp(self):
        super().setUp()
        self.config_file = self.config("icp-slam-superray-only.ini")
        self.log = self.folder / "LOG_ICP-SLAM_SUPERRAY_ONLY"

    def test_slam_on_our_map_alone(self):
        _, errors = self.run_as_documented("icp-slam", self.config_file.name,
                                           self.dataset(RAWLOG))
        self.assertIn(PLUGIN_MESSAGE, errors)
        self.assertEqual(list(self.log.glob("_finalmaps_*_mrpt__*")), [], "no other map")
        name = "superray__CSuperRayPointsMap2D_00"
        map_file, = self.log.glob(f"_finalmaps_*{name}.srmap")
        self.assertGreater(self.info(map_file)["cells"]["occupied"], 3000)
        rebuilt = self.build_map(self.log / "_finalmap_.simplemap", "--map",
                                 "CSuperRayGridMap2D", "--config", self.config_file,
                                 "--section", "MappingApplication_superRayPointsMap2D_00")
        self.assertEqual(self.digest(map_file), self.digest(rebuilt))

        # ICP did its work: the robot ends where icp-slam with MRPT's points map has
        # it end, and not where odometry does.
        path = read_path(self.log / "log_estimated_path.txt")
        odometry = read_path(self.log / "log_odometry_path.txt")
        self.run_program("icp-slam", self.config("icp-slam-superray.ini"),
                         self.dataset(RAWLOG), preload=True)
        stock = read_path(self.folder / "LOG_ICP-SLAM_SUPERRAY/log_estimated_path.txt")
        self.assertEqual(len(path), len(stock))
        print(f"icp-slam: {distance(path[-1], stock[-1]):.2f} m from MRPT's points map,"
              f" odometry {distance(odometry[-1], stock[-1]):.2f} m")
        self.assertLess(distance(path[-1], stock[-1]), 1)
        self.assertGreater(distance(odometry[-1], stock[-1]), 5)

        # SAVE_3D_SCENE = 1 shows the map as it was then.
        scenes = sorted(self.log.glob("buildingmap_*.3Dscene"))
        self.assertGreater(len(scenes), 3)
        for scene in scenes:
            self.assertIn(b"COctoMapVoxels", decompressed(scene))
        self.assertGreater(scenes[-1].stat().st_size, 2 * scenes[0].stat().st_size)

    def test_without_the_plugin_there_is_no_map(self):
        self.run_any("icp-slam", self.config_file, self.dataset(RAWLOG))
        self.assertEqual(list(self.log.glob("*superray*")), [])


if __name__ == "__main__":
    unittest.main()
