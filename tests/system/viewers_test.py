# SPDX-License-Identifier: BSD-3-Clause
"""Stock SceneViewer3D and RawLogViewer with the plugin (-l), driven by mouse and keys.

The windows open in a virtual screen (xvfb-run); where that, xdotool or ImageMagick's
`import` is missing, nothing is tested, and the output says so.
"""

import os
import shutil
import subprocess
import sys
import time
import unittest

from programs import PLUGIN_MESSAGE, VIEWER_TITLE_IS_FIXED, ProgramTest

SCREEN = "1280x1024x24"
INSIDE = "SUPERRAY_TEST_INSIDE_XVFB"


class Picture:
    """Pixels of the screen."""

    def __init__(self, ppm):
        magic, size, depth, self.pixels = ppm.split(b"\n", 3)
        assert (magic, depth) == (b"P6", b"255"), (magic, depth)
        self.width = int(size.split()[0])

    def count(self, left, top, right, bottom, wanted):
        """Number of pixels of which wanted(red, green, blue) holds."""
        found = 0
        for y in range(top, bottom):
            row = self.pixels[3 * (y * self.width + left):3 * (y * self.width + right)]
            found += sum(map(wanted, row[0::3], row[1::3], row[2::3]))
        return found


def colourful(red, green, blue):
    """Not grey as the background and all of the window's decoration."""
    return max(red, green, blue) - min(red, green, blue) > 60


class Viewers(ProgramTest):
    def setUp(self):
        super().setUp()
        self.patience = 1
        for name in ("xvfb-run", "xdotool", "import"):
            self.program(name)

    def start(self, *command):
        """Starts a program with windows, which is ended with the test."""
        self.log = self.folder / "viewer.log"
        environment = dict(self.environment(), HOME=str(self.folder))
        with open(self.log, "wb") as log:
            viewer = subprocess.Popen([self.program(command[0])] + [str(c) for c in command[1:]],
                                      cwd=self.folder, env=environment, stdout=log, stderr=log,
                                      stdin=subprocess.DEVNULL)

        def end():
            viewer.kill()
            viewer.wait()
        self.addCleanup(end)
        return end

    def xdotool(self, *arguments):
        done = subprocess.run(["xdotool"] + [str(a) for a in arguments], capture_output=True,
                              text=True, timeout=30)
        return done.stdout.strip()

    def wait_for(self, what, condition, seconds=30):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            result = condition()
            if result:
                return result
            time.sleep(0.2)
        self.fail(f"{what} did not come; the program said:\n"
                  f"{self.log.read_text(errors='replace')[-2000:]}")

    def window(self, title):
        """Id of the window with this in its title, when it is there."""
        found = self.wait_for(f"window '{title}'", lambda: self.xdotool(
            "search", "--onlyvisible", "--name", title).split())
        self.pause(0.5)  # for its contents
        return found[0]

    def pause(self, seconds):
        """For windows to follow; there is nothing to see that they did."""
        time.sleep(seconds * self.patience)

    def type(self, text):
        self.xdotool("type", "--delay", 20 * self.patience, text)  # faster, keys get lost
        self.xdotool("key", "Return")
        self.pause(0.1)

    def place(self, window, width, height):
        self.xdotool("windowmove", window, 0, 0)
        self.xdotool("windowsize", window, width, height)
        self.pause(0.5)

    def click(self, window, x, y):
        self.xdotool("mousemove", "--window", window, x, y, "click", 1)

    def picture(self):
        done = subprocess.run(["import", "-window", "root", "-depth", "8", "ppm:-"],
                              capture_output=True, timeout=30, check=True)
        if os.environ.get("SUPERRAY_KEEP_PICTURES"):
            name = f"{self.id().split('.')[-1]}_{time.monotonic_ns()}.ppm"
            with open(os.path.join(os.environ["SUPERRAY_KEEP_PICTURES"], name), "wb") as file:
                file.write(done.stdout)
        return Picture(done.stdout)


class SceneViewer(Viewers):
    def coloured_pixels(self, scene, at_least):
        """Starts the viewer, comes closer and counts what is not background."""
        self.assert_documented("SceneViewer3D -l libsuperray-maps.so room.3Dscene")
        end = self.start("SceneViewer3D", "-l", self.plugin, scene)
        window = self.window("SceneViewer3D - Part of"
                             if self.mrpt_version() >= VIEWER_TITLE_IS_FIXED else scene.name)
        self.place(window, 1270, 1000)
        self.xdotool("mousemove", "--window", window, 700, 500, "click", "--repeat", 10,
                     "--delay", 50, 4)
        found = 0
        for _ in range(10):
            time.sleep(1)
            found = self.picture().count(90, 40, 1260, 960, colourful)
            if found >= at_least:
                break
        self.assertIn(PLUGIN_MESSAGE, self.log.read_text(errors="replace"))
        end()
        return found

    def test_shows_our_voxels(self):
        room = self.build_map(self.dataset("tests_rgbd.rawlog"), "--fixed-robot",
                              "--resolution", "0.05")
        scene = self.folder / "room.3Dscene"
        self.run_program(self.superray_map, "export", room, scene)
        self.assertGreater(self.coloured_pixels(scene, 10000), 10000)

    def test_free_space_is_not_shown(self):
        empty = self.build_map(self.dataset("tests_rgbd.rawlog"), "--fixed-robot",
                               "--max-range", "0.5")
        cells = self.info(empty)["cells"]
        self.assertEqual(cells["occupied"], 0)
        self.assertGreater(cells["free"], 10)
        scene = self.folder / "free.3Dscene"
        self.run_program(self.superray_map, "export", empty, scene)
        self.assertEqual(self.coloured_pixels(scene, 0), 0)


class RawLog(Viewers):
    INI = ["[map]", "superRayGridMap2D_count = 1",
           "[map_superRayGridMap2D_00_creationOpts]", "resolution = 0.05"]

    def raw_map(self, rawlog, prefix):
        """Drives the dialog "Raw-map"; a picture of the map's preview."""
        self.assert_documented("RawLogViewer -l libsuperray-maps.so FILE.rawlog")
        end = self.start("RawLogViewer", "-l", self.plugin, rawlog)
        tip = self.window("Tip of the Day")
        main = self.window("RawlogViewer - Part of")
        self.place(main, 1270, 1000)
        self.xdotool("windowfocus", tip, "key", "Escape")
        self.wait_for("end of the tip", lambda: not self.xdotool(
            "search", "--onlyvisible", "--name", "Tip of the Day"))
        self.assertIn(PLUGIN_MESSAGE, self.log.read_text(errors="replace"))

        self.click(main, 225, 62)  # the button "Raw-map"
        dialog = self.window("Creation of")
        self.xdotool("windowmove", dialog, 0, 0)
        self.pause(0.3)
        self.click(dialog, 700, 200)  # the text with the maps
        self.pause(0.2)
        self.xdotool("key", "ctrl+a")
        self.assert_documented("\n".join(self.INI) + "\n```\n")
        for line in self.INI:
            self.type(line)
        self.pause(0.5)
        self.click(dialog, 130, 192)  # "Map from odometry"
        self.pause(2)
        self.click(dialog, 130, 243)  # "Save map as text..."
        self.window("Save as text file")
        self.type(prefix.name)  # the dialog starts in the rawlog's folder
        self.pause(1)
        saved = list(prefix.parent.glob(prefix.name + "*.srmap"))
        if saved:
            self.click(dialog, 300, 277)  # "Preview map in 3D"
            self.pause(2)
        picture = self.picture()
        end()
        return saved, picture

    def test_raw_map_from_odometry(self):
        rawlog = self.folder / "drive.rawlog"
        shutil.copy(self.dataset("localization_demo.rawlog"), rawlog)
        expected = self.digest(self.build_map(rawlog, "--map", "CSuperRayGridMap2D",
                                              "--resolution", "0.05"))
        for self.patience in (1, 2, 5):  # windows of a busy machine may miss a click
            saved, picture = self.raw_map(rawlog, self.folder / f"map{self.patience}")
            if saved:
                break
        self.assertEqual(len(saved), 1, self.log.read_text(errors="replace")[-2000:])
        self.assertIn("superray__CSuperRayGridMap2D_00", saved[0].name)
        self.assertEqual(self.digest(saved[0]), expected)
        # The window of the preview, at the upper left, shows the walls in dark red.
        walls = picture.count(0, 0, 395, 295, lambda r, g, b: r > 80 and g < 60 and b < 60)
        self.assertGreater(walls, 200)


if __name__ == "__main__":
    if INSIDE not in os.environ and shutil.which("xvfb-run"):
        os.environ[INSIDE] = "1"
        os.execvp("xvfb-run", ["xvfb-run", "-a", "-s", f"-screen 0 {SCREEN}", sys.executable,
                               "-B"] + sys.argv)
    unittest.main()
