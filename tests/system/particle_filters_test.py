# SPDX-License-Identifier: BSD-3-Clause
"""Stock pf-localization and rbpf-slam with a map of ours and no other."""

import re
import shutil
import unittest

from programs import PLUGIN_MESSAGE, ProgramTest
from simulated_drive import SimulatedDrive, distance, read_path


class Localization(ProgramTest):
    ESTIMATE = re.compile(
        r"PDF estimation: \(([-\d.]+),([-\d.]+),([-\d.]+)deg\).*tr\(cov\): ([-\d.e]+)")

    def estimates(self, output):
        """(x, y, yaw, trace of the covariance) of each step."""
        return [tuple(map(float, e)) for e in self.ESTIMATE.findall(output)]

    def test_converges_to_the_true_pose(self):
        drive = SimulatedDrive(self)
        shutil.copy(drive.world, self.folder / "localization.srmap")
        output, errors = self.run_as_documented(
            "pf-localization", "pf-localization-superray.ini", drive.rawlog)
        self.assertIn(PLUGIN_MESSAGE, errors)
        estimates = self.estimates(output)
        self.assertEqual(len(estimates), len(drive.path))
        error = [distance(e, truth) for e, truth in zip(estimates, drive.path)]
        last = sum(error[-10:]) / 10  # particles are not seeded
        print(f"pf-localization: {last:.3f} m off at last, trace {estimates[-1][3]}")
        self.assertLess(estimates[-1][3], 0.3)
        self.assertLess(last, 0.10)
        self.assertLess(sorted(error[20:])[len(error[20:]) // 2], 0.10)

        # The map is the loaded one; nothing was inserted.
        saved, = self.folder.glob("LOG_LOCALIZATION_SUPERRAY_*/map_superray__*.srmap")
        self.assertEqual(self.digest(saved), self.digest(drive.world))

    def test_without_the_plugin_it_cannot_localise(self):
        done = self.run_without_plugin(
            "pf-localization", self.config("pf-localization-superray.ini"),
            self.dataset("localization_demo.rawlog"))
        self.assertEqual(list(self.folder.glob("LOG*/map_superray__*")), [])
        if done:
            output, _ = done
            self.assertGreater(self.estimates(output)[-1][3], 3, "no map: particles everywhere")


class RbpfSlam(ProgramTest):
    def slam(self, algorithm, drive):
        """(error of the SLAM, error of odometry) at the end [m]"""
        name = "rbpf-slam-superray.ini"
        if algorithm == 0:
            _, errors = self.run_as_documented("rbpf-slam", name, drive.rawlog)
        else:
            config = self.folder / name
            text = self.config(name).read_text()
            self.assertIn("\nPF_algorithm = 0\n", text)
            config.write_text(text.replace("\nPF_algorithm = 0\n",
                                           f"\nPF_algorithm = {algorithm}\n"))
            _, errors = self.run_program("rbpf-slam", config, drive.rawlog, preload=True)
        self.assertIn(PLUGIN_MESSAGE, errors)
        log = self.folder / "LOG_RBPF-SLAM_SUPERRAY"
        maps = list(log.glob("finalMap_superray__CSuperRayGridMap2D_00.srmap"))
        self.assertEqual(len(maps), 1)
        self.assertEqual(list(log.glob("finalMap_mrpt*")), [], "ours is the only map")
        info = self.info(maps[0])
        self.assertAlmostEqual(info["resolution"], 0.07)
        self.assertGreater(info["cells"]["occupied"], 2000)
        errors = [distance(read_path(log / f"log_{name}_path.txt")[-1], drive.path[-1])
                  for name in ("estimated", "odometry")]
        print(f"rbpf-slam, algorithm {algorithm}: {errors[0]:.2f} m off at the end,"
              f" odometry {errors[1]:.2f} m")
        return errors

    def test_it_corrects_odometry_by_the_likelihood_of_our_map(self):
        drive = SimulatedDrive(self)
        for algorithm in (0, 3):
            error, odometry_error = self.slam(algorithm, drive)
            self.assertGreater(odometry_error, 9)
            self.assertLess(error, 0.7 * odometry_error)  # particles are not seeded


if __name__ == "__main__":
    unittest.main()
