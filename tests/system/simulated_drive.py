# SPDX-License-Identifier: BSD-3-Clause
"""A drive with exactly known poses, made by stock MRPT programs.

icp-slam drives the recorded loop with our points map as its only map; that map,
taken for the world, is scanned again by simul-gridmap from icp-slam's path.
Odometry stays the recorded one, which ends more than 9 m off.
"""

import math

from programs import decompressed

LOOP_RAWLOG = "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog"


def read_path(path):
    """Poses (x, y, yaw) of the lines 'step x y ...' that MRPT's programs log."""
    rows = (line.split() for line in path.read_text().splitlines())
    return [tuple(float(v) for v in row[1:4]) for row in rows if row[0].isdigit()]


def distance(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def from_first_action(rawlog):
    """The objects of a rawlog from its first actions on.

    Not by rawlog-edit --cut, which writes everything from MRPT 2.12.1 on.
    """
    name = b"CActionCollection"
    start = rawlog.find(bytes([0x80 | len(name)]) + name)  # how MRPT begins an object
    assert start > 0, "no actions in the rawlog"
    return rawlog[start:]


class SimulatedDrive:
    """`world`: the map (.srmap); `rawlog`; `path`: true poses, one per scan."""

    def __init__(self, test):
        folder = test.folder
        loop = test.dataset(LOOP_RAWLOG)
        test.run_as_documented("icp-slam", "icp-slam-superray-only.ini", loop)
        log = folder / "LOG_ICP-SLAM_SUPERRAY_ONLY"
        path_file = log / "log_estimated_path.txt"
        self.path = read_path(path_file)
        self.world, = log.glob("*superray__CSuperRayPointsMap2D_00.srmap")
        picture, = log.glob("*superray__CSuperRayPointsMap2D_00.png")

        info = test.info(self.world)
        x, y = (round(-low / info["resolution"]) for low in info["bounds"]["min"])
        test.run_program("image2gridmap", "-i", picture, "-o", folder / "world.gridmap",
                         "-r", info["resolution"], "--px", x, "--py", y)
        # simul-gridmap wants action/observation pairs from the first entry on.
        (folder / "pairs.rawlog").write_bytes(from_first_action(decompressed(loop)))
        self.rawlog = folder / "simulated.rawlog"
        test.run_program("simul-gridmap", "-n", "-g", folder / "world.gridmap",
                         "-p", path_file, "-i", folder / "pairs.rawlog", "-o", self.rawlog)
