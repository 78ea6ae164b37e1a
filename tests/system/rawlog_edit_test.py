# SPDX-License-Identifier: BSD-3-Clause
"""Stock rawlog-edit with the plugin (-p), and maps of what it writes."""

import re
import unittest

from programs import PLUGIN_MESSAGE, ProgramTest

RGBD = ("tests_rgbd.rawlog", "OPENNI2")
VELODYNE = ("test_velodyne_VLP16.rawlog", "Velodyne1_SCAN")


class RawlogEdit(ProgramTest):
    def edit(self, *arguments):
        """Path of what rawlog-edit wrote."""
        self.edited = getattr(self, "edited", 0) + 1
        path = self.folder / f"edited{self.edited}.rawlog"
        _, log = self.run_program("rawlog-edit", "-p", self.plugin, *arguments, "-o", path)
        self.assertIn(PLUGIN_MESSAGE, log)
        return path

    def map_of(self, rawlog, *options):
        """Digest of the map of a rawlog without robot poses."""
        options = options or ("--fixed-robot",)
        path = self.build_map(rawlog, *options, "--resolution", "0.05", "--max-range", "10")
        self.assertGreater(self.info(path)["cells"]["occupied"], 500)
        return self.digest(path)

    def both(self):
        """A rawlog with two sensors."""
        path = self.folder / "both.rawlog"
        path.write_bytes(b"".join(self.dataset(name).read_bytes()
                                  for name, _ in (RGBD, VELODYNE)))
        return path

    def skip_if_edits_write_everything(self, *arguments):
        """A bug of rawlog-edit from MRPT 2.12.1 on: edits do not leave anything out.

        The arguments are an edit that must leave one of two objects.
        """
        edited = self.edit(*arguments, "-i", self.both())
        info, _ = self.run_program("rawlog-edit", "--info", "-i", edited)
        objects = re.search(r"Overall number of objects +: (\d+)", info)
        self.assertIsNotNone(objects, info)
        if int(objects[1]) != 1:
            self.skip_loudly(f"stock rawlog-edit {arguments[0]} of MRPT "
                             f"{'.'.join(map(str, self.mrpt_version()))} leaves {objects[1]} "
                             "objects of 2, where it must leave 1")

    def test_info(self):
        rawlog = self.dataset(RGBD[0])
        plain, errors = self.run_program("rawlog-edit", "--info", "-i", rawlog)
        self.assertNotIn(PLUGIN_MESSAGE, errors)
        loaded, errors = self.run_program("rawlog-edit", "-p", self.plugin, "--info", "-i", rawlog)
        self.assertIn(PLUGIN_MESSAGE, errors)
        for line in plain.splitlines():
            if "number of objects" in line or "labels" in line:
                self.assertIn(line, loaded)
        self.assertIn(RGBD[1], loaded)

    def test_cut_and_keep_label_leave_one_sensor(self):
        self.skip_if_edits_write_everything("--cut", "--to-index", "0")
        self.skip_if_edits_write_everything("--keep-label", RGBD[1])
        both = self.both()
        expected = {label: self.map_of(self.dataset(name)) for name, label in (RGBD, VELODYNE)}
        self.assertNotEqual(*expected.values())
        self.assertNotIn(self.map_of(both), expected.values())
        cuts = {
            RGBD[1]: [["--cut", "--to-index", "0"], ["--cut", "--to-time", "1500000000"]],
            VELODYNE[1]: [["--cut", "--from-index", "1"], ["--cut", "--from-time", "1500000000"]],
        }
        for label, edits in cuts.items():
            for arguments in edits + [["--keep-label", label]]:
                with self.subTest(label=label, arguments=arguments):
                    edited = self.edit(*arguments, "-i", both)
                    self.assertEqual(self.map_of(edited), expected[label])

    def test_cut_of_action_observation_pairs(self):
        self.skip_if_edits_write_everything("--cut", "--to-index", "0")
        rawlog = self.dataset("localization_demo.rawlog")
        options = ("--map", "CSuperRayGridMap2D")
        copy = self.edit("--cut", "--from-index", "0", "-i", rawlog)
        self.assertEqual(self.map_of(copy, *options), self.map_of(rawlog, *options))
        half = self.edit("--cut", "--to-index", "39", "-i", rawlog)
        self.assertEqual(self.map_of(half, *options),
                         self.map_of(rawlog, *options, "--scans", "20"))

    def test_externalized_observations_are_loaded(self):
        rawlog = self.dataset(RGBD[0])
        edited = self.edit("--externalize", "-i", rawlog)
        images = self.folder / (edited.stem + "_Images")
        self.assertEqual(len(list(images.glob("*_RANGES.bin"))), 1)
        self.assertLess(edited.stat().st_size, rawlog.stat().st_size / 100)
        self.assertEqual(self.map_of(edited), self.map_of(rawlog))

    def test_generated_point_clouds_change_nothing(self):
        """A range image says all that the points made from it say."""
        rawlog = self.dataset(RGBD[0])
        edited = self.edit("--generate-3d-pointclouds", "-i", rawlog)
        self.assertGreater(edited.stat().st_size, 1.5 * rawlog.stat().st_size)
        self.assertEqual(self.map_of(edited), self.map_of(rawlog))

    def test_sensor_poses(self):
        rawlog = self.dataset(RGBD[0])
        poses = self.folder / "poses.ini"
        poses.write_text(f"[camera]\nsensorLabel = {RGBD[1]}\npose_x = 1.5\npose_y = -0.5\n"
                         "pose_z = 0.7\npose_yaw = 90\npose_pitch = 0\npose_roll = 0\n")
        edited = self.edit("--sensors-pose", poses, "-i", rawlog)
        # A sensor there on a robot here is a sensor on a robot there.
        truth = self.folder / "robot.txt"
        truth.write_text("".join(f"{t} 1.5 -0.5 0.7 1.5707963267948966 0 0\n"
                                 for t in (1462879440, 1462879450)))
        moved = self.map_of(edited)
        self.assertEqual(moved, self.map_of(rawlog, "--poses", truth,
                                            "--max-pose-gap", "20"))
        self.assertNotEqual(moved, self.map_of(rawlog))


if __name__ == "__main__":
    unittest.main()
