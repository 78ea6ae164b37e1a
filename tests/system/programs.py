# SPDX-License-Identifier: BSD-3-Clause
"""Runs programs for the system tests.

What to test comes from the environment:
  SUPERRAY_MAP         the program superray-map
  SUPERRAY_PLUGIN      libsuperray-maps.so
  SUPERRAY_SOURCE_DIR  this repository
  SUPERRAY_BUILD_DIR   where it was built
"""

import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

DATASETS = pathlib.Path("/usr/share/mrpt/datasets")
PLUGIN_MESSAGE = "map classes registered"


# Versions of MRPT from which on stock programs behave otherwise.
UNKNOWN_MAPS_ARE_ERRORS = (2, 11, 3)
VIEWER_TITLE_IS_FIXED = (2, 15, 0)


def decompressed(path):
    """Contents of a file that MRPT wrote: gzip, zstd (from 2.15.7 on) or plain."""
    data = path.read_bytes()
    if data[:2] == b"\x1f\x8b":
        return gzip.decompress(data)
    if data[:4] == b"\x28\xb5\x2f\xfd":
        try:
            from compression import zstd  # Python 3.14
        except ImportError:
            return subprocess.run(["zstd", "-dc", str(path)], check=True,
                                  capture_output=True).stdout
        return zstd.decompress(data)
    return data


def path_from_environment(name):
    return pathlib.Path(os.environ[name]).resolve()


class ProgramTest(unittest.TestCase):
    """Each test runs in a folder of its own, removed afterwards."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="superray-test-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.superray_map = path_from_environment("SUPERRAY_MAP")
        self.plugin = path_from_environment("SUPERRAY_PLUGIN")
        self.source = path_from_environment("SUPERRAY_SOURCE_DIR")
        self.build = path_from_environment("SUPERRAY_BUILD_DIR")

    def environment(self, preload=False):
        environment = dict(os.environ)
        environment.pop("LD_PRELOAD", None)
        environment.pop("SUPERRAY_QUIET", None)
        if preload:
            environment["LD_PRELOAD"] = str(self.plugin)
        return environment

    def program(self, name):
        """Path of a program; without it the test is skipped, and says so."""
        path = shutil.which(str(name))
        if path is None:
            self.skip_loudly(f"{name} is not installed")
        return path

    def skip_loudly(self, reason):
        print(f"SKIPPED, NOT TESTED: {reason}", file=sys.stderr)
        self.skipTest(reason)

    def mrpt_version(self):
        """Of the stock programs, e.g. (2, 5, 8)."""
        _, output, errors = self.run_any("rawlog-edit", "--version")  # its status is 1
        version = re.search(r"MRPT (\d+)\.(\d+)\.(\d+)", output + errors)
        self.assertIsNotNone(version, output + errors)
        return tuple(map(int, version.groups()))

    def run_any(self, *command, preload=False, folder=None):
        """Runs a program without a keyboard: (exit status, output, errors)."""
        done = subprocess.run([self.program(command[0])] + [str(c) for c in command[1:]],
                              cwd=folder or self.folder, env=self.environment(preload),
                              stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              errors="replace")
        return done.returncode, done.stdout, done.stderr

    def run_program(self, *command, preload=False, folder=None):
        """Runs a program that must succeed: (output, errors)."""
        status, output, errors = self.run_any(*command, preload=preload, folder=folder)
        self.assertEqual(status, 0,
                         f"{command} failed:\n{output[-3000:]}{errors[-3000:]}")
        return output, errors

    def run_without_plugin(self, *command):
        """Runs a program with a configuration that asks for our maps, but no plugin.

        (output, errors), or None where MRPT must refuse to run, and did.
        """
        status, output, errors = self.run_any(*command)
        self.assertNotIn(PLUGIN_MESSAGE, output + errors)
        if self.mrpt_version() >= UNKNOWN_MAPS_ARE_ERRORS:
            self.assertNotEqual(status, 0, output[-2000:] + errors[-2000:])
            self.assertRegex(output + errors, "no such registered CMetricMap class 'superRay")
            return None
        self.assertEqual(status, 0, output[-2000:] + errors[-2000:])
        return output, errors

    def assert_documented(self, text):
        """What a test does with a stock program is what doc/mrpt.md tells to do."""
        self.assertIn(text, (self.source / "doc/mrpt.md").read_text())

    def run_as_documented(self, program, config, rawlog):
        """A SLAM program with a configuration file that comes with the library."""
        self.assert_documented(
            f"LD_PRELOAD=libsuperray-maps.so {program} {config} FILE.rawlog </dev/null\n")
        return self.run_program(program, self.config(config), rawlog, preload=True)

    def config(self, name):
        """One of the configuration files that come with the library."""
        return self.source / "share/config_files" / name

    def build_map(self, *arguments):
        """Path of a map that superray-map built."""
        self.maps_built = getattr(self, "maps_built", 0) + 1
        path = self.folder / f"built{self.maps_built}.srmap"
        self.run_program(self.superray_map, "build", *arguments, "-o", path)
        return path

    def info(self, path):
        output, _ = self.run_program(self.superray_map, "info", path, "--json")
        return json.loads(output)

    def digest(self, path):
        digest = self.info(path)["digest"]
        self.assertRegex(digest, re.compile("^[0-9a-f]{32}$"))
        return digest

    def dataset(self, name):
        path = DATASETS / name
        self.assertTrue(path.exists(), f"no {path}: is mrpt-common installed?")
        return path
