# SPDX-License-Identifier: BSD-3-Clause
"""Two copies of the plugin in one process: the second one is refused with a line."""

import os
import shutil
import subprocess
import tempfile
import unittest

PLUGIN = os.environ["SUPERRAY_PLUGIN"]


def run(*libraries):
    environment = dict(os.environ, LD_PRELOAD=":".join(libraries))
    return subprocess.run(["/bin/true"], env=environment, capture_output=True, text=True,
                          timeout=60, check=False)


class PluginCopies(unittest.TestCase):
    def test_the_second_one_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            copies = [os.path.join(folder, name) for name in ("a.so", "b.so")]
            for copy in copies:
                shutil.copyfile(PLUGIN, copy)
            once = run(copies[0])
            self.assertEqual(once.returncode, 0, once.stderr)
            self.assertIn("map classes registered", once.stderr)
            # The same file twice is loaded once.
            again = run(copies[0], copies[0])
            self.assertEqual(again.returncode, 0, again.stderr)
            twice = run(*copies)
            self.assertEqual(twice.returncode, 1, twice.stderr)
            self.assertIn("second copy of the plugin", twice.stderr)
            self.assertTrue(any(copy in twice.stderr for copy in copies), twice.stderr)


if __name__ == "__main__":
    unittest.main()
