"""Tests of the range of values that colours span."""
import unittest

import numpy as np

import runs  # This module adds the package's path.
from lichtenberg.ranges import colour_range, range_ends, set_colours


class RangeTest(unittest.TestCase):
    def test_it_reaches_to_the_largest_unless_few_stand_far_out(self):
        even = np.linspace(0, 10, 1001)
        self.assertEqual(colour_range("radius", even), (0, 10))
        low, high = colour_range("radius", np.append(even, 1000))
        self.assertEqual(low, 0)
        # 99.5 % of 1001 positive numbers with a spacing of 0.01.
        self.assertAlmostEqual(high, 9.96, delta=0.011)
        # Not an outlier: less than twice the end of the others.
        self.assertEqual(colour_range("radius", np.append(even, 19)), (0, 19))

    def test_white_is_zero_where_there_is_a_sign(self):
        self.assertEqual(colour_range("potential", np.array([100.0, 5000.0])), (-5000, 5000))
        self.assertEqual(colour_range("anything", np.array([-1.0, 3.0])), (-3, 3))
        self.assertEqual(colour_range("radius", np.array([2.0, 3.0])), (2, 3))
        self.assertEqual(range_ends(np.array([-2.0, np.nan, 5.0])), (2, 5))

    def test_nothing_and_what_is_no_number_have_a_range_too(self):
        self.assertEqual(colour_range("charge", np.zeros(3)), (-1, 1))
        self.assertEqual(colour_range("radius", np.array([np.nan])), (0, 1))

    def test_no_two_sets_share_a_colour(self):
        colours = np.round(255 * set_colours(np.arange(400)))
        self.assertEqual(len(np.unique(colours, axis=0)), 400)
        near = set_colours(np.arange(12))  # The colours of a few sets are clearly different.
        distance = np.linalg.norm(near[:, None] - near[None], axis=2) + np.eye(12)
        self.assertGreater(distance.min(), 0.2)


if __name__ == "__main__":
    unittest.main()
