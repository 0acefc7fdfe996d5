"""Tests of perspective pictures: the axis of the box that points up."""
import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "python"))
from lichtenberg.pictures import space  # noqa: E402

BOX = np.array([1.0, 2.0, 3.0])


class Up(unittest.TestCase):
    def test_the_fall_points_down_in_the_picture(self):
        for down in ([0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [0.1, 0.2, -0.9], None):
            camera = space.Camera(BOX, down)
            axis = 1 if down is None else np.argmax(np.abs(down))
            fall = np.zeros(3)
            fall[axis] = -1 if down is None else np.sign(down[axis])
            self.assertAlmostEqual(np.linalg.det(camera.axes), -1)  # Right, up and away from the camera.
            shown = camera.axes @ fall
            self.assertAlmostEqual(shown[0], 0)
            self.assertLess(shown[1], -0.9)

    def test_without_gravity_y_is_up_and_z_towards_the_eye(self):
        right, up, away = space.Camera(BOX).axes
        self.assertGreater(right[0], 0.8)
        self.assertGreater(up[1], 0.9)
        self.assertLess(away[2], -0.8)

    def test_a_cut_keeps_what_lies_behind_it(self):
        corners = space.corners(BOX)
        for down in (None, [0, 0, -1], [1, 0, 0]):
            camera = space.Camera(BOX, down)
            for axis in range(3):
                kept = space.behind_cut(corners, (axis, BOX[axis] / 2), camera)
                self.assertEqual(kept.sum(), 4)
                self.assertGreater(camera.depth(corners[kept]).mean(), camera.depth(corners[~kept]).mean())


if __name__ == "__main__":
    unittest.main()
