# SPDX-License-Identifier: BSD-3-Clause
"""The .ini files of share/examples/sensors, with scans of such sensors."""

import re
import unittest

from programs import ProgramTest

# File, its map, recording in mrpt-common, fewest occupied cells.
EXAMPLES = [
    ("kinect", "CSuperRayGridMap3D", "tests_rgbd.rawlog", 10000),
    ("vlp16", "CSuperRayGridMap3D", "test_velodyne_VLP16.rawlog", 3000),
    # mrpt-common has no HDL-64; what its options do is seen with any Velodyne.
    ("hdl64", "CSuperRayOctoMap", "test_velodyne_VLP16.rawlog", 3000),
    ("laser2d", "CSuperRayGridMap2D", "localization_demo.rawlog", 500),
]


class SensorExamples(ProgramTest):
    def options_in(self, config):
        """{section: {key: value}} of a file of ours."""
        options, section = {}, None
        for line in config.read_text().splitlines():
            line = re.sub(r"(//|#).*", "", line).strip()
            if re.fullmatch(r"\[.*\]", line):
                section = line[1:-1].split("_")[-1]
            elif line:
                key, value = (part.strip() for part in line.split("="))
                options.setdefault(section, {})[key] = value
        return options

    def test_each_makes_the_map_that_it_says(self):
        folder = self.source / "share/examples/sensors"
        self.assertEqual(sorted(path.stem for path in folder.iterdir()),
                         sorted(name for name, *_ in EXAMPLES))
        for name, class_name, recording, fewest in EXAMPLES:
            with self.subTest(name):
                config = folder / f"{name}.ini"
                poses = [] if name == "laser2d" else ["--fixed-robot"]
                built = self.build_map(self.dataset(recording), "--config", config,
                                       "--section", "map", *poses)
                info = self.info(built)
                self.assertEqual(info["class"], class_name)
                self.assertGreater(info["cells"]["occupied"], fewest)
                checked = 0
                for section, options in self.options_in(config).items():
                    for key, value in options.items():
                        if section == "map":
                            continue
                        self.assertEqual(info["options"][section][key], value, key)
                        checked += 1
                self.assertGreater(checked, 5)

    def test_hdl64_recording(self):
        recording = self.source.parent / "shared/data/kitti_hdl64.rawlog"
        if not recording.exists():
            self.skipTest(f"SKIPPED, no recording {recording}")
        built = self.build_map(recording, "--config",
                               self.source / "share/examples/sensors/hdl64.ini",
                               "--section", "map", "--scans", "2")
        self.assertGreater(self.info(built)["cells"]["occupied"], 20000)


if __name__ == "__main__":
    unittest.main()
