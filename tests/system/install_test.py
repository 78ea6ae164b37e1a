# SPDX-License-Identifier: BSD-3-Clause
"""An installed superray is found and used by other projects; so is the example."""

import re
import unittest

from programs import ProgramTest


class Install(ProgramTest):
    def setUp(self):
        super().setUp()
        self.prefix = self.folder / "prefix"
        self.run_program("cmake", "--install", self.build, "--prefix", self.prefix)

    def build_project(self, source):
        binary = self.folder / f"build-{source.name}"
        self.run_program("cmake", "-S", source, "-B", binary, "-G", "Ninja",
                         "-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.run_program("cmake", "--build", binary)
        return binary

    def test_projects_find_and_use_it(self):
        example = self.build_project(self.source / "share/examples/embed")
        output, _ = self.run_program(example / "embed")
        self.assertIn("40 cells occupied", output)

        # The installed program runs from where it is, and reads the map.
        installed = self.prefix / "bin/superray-map"
        self.superray_map = installed
        info = self.info(self.folder / "wall.srmap")
        self.assertEqual(info["cells"]["occupied"], 40)
        self.assertAlmostEqual(info["resolution"], 0.05)

        consumer = self.build_project(self.source / "tests/system/consumer")
        self.assertEqual(self.run_program(consumer / "core_only"), ("4 cells\n", ""))
        self.assertEqual(self.run_program(consumer / "storage_only"), ("equal\n", ""))

    def test_what_is_installed(self):
        def exists(pattern):
            self.assertNotEqual(list(self.prefix.glob(pattern)), [], pattern)

        exists("bin/superray-map")
        exists("bin/superray-slam")
        help_text, errors = self.run_program(self.prefix / "bin/superray-slam", "--help")
        self.assertIn("superray-slam evaluate", help_text)
        self.assertEqual(errors, "")
        exists("lib/**/libsuperray-maps.so")
        exists("include/superray/core/scan_integrator.h")
        exists("include/superray/maps/CSuperRayOctoMap.h")
        exists("lib/**/cmake/superray/superray-config.cmake")
        exists("share/superray/config_files/icp-slam-superray.ini")
        # Nothing installed names the folder that it was built from.
        for path in self.prefix.glob("**/*.cmake"):
            self.assertNotIn(str(self.source), path.read_text(), path)


class Readme(ProgramTest):
    def test_the_readme_shows_the_example_as_it_is(self):
        licence, example = (self.source / "share/examples/embed/main.cpp").read_text().split(
            "\n", 1)
        self.assertIn("SPDX", licence)
        code = re.findall(r"```cpp\n(.*?)```", (self.source / "README.md").read_text(), re.S)
        self.assertIn(example, code)


if __name__ == "__main__":
    unittest.main()
