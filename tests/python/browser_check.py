"""Checks that Chromium shows the page of a run without errors. If Chromium is not installed, the exit status is 77,
which ctest reports as skipped."""
import sys
import unittest

import numpy as np

import browser
import runs
from lichtenberg import load
from view_test import page_of


class BrowserTest(unittest.TestCase):
    def test_a_tree_in_the_plane(self):
        with browser.Browser(page_of(runs.seedling())) as shown:
            self.assertEqual(shown.value("document.getElementById('now').textContent"), "0.3 s, frame 3")
            pictures = [shown.picture()]
            for control, value in [("frame", 0), ("colour", "charge"), ("contacts", True), ("radius", 0.5), ("log", True)]:
                shown.choose(control, value)
                pictures.append(shown.picture())
            self.assertEqual(len(set(pictures)), len(pictures))  # Each change is visible.
            self.assertEqual(shown.value("document.getElementById('now').textContent"), "0 s, frame 0")
            shown.value("document.getElementById('play').click()")
            shown.wait_for("document.getElementById('frame').value > 1")
            self.assertEqual(shown.complaints, [])

    def test_colours_are_those_of_the_scale(self):
        """The pixel in the middle of each particle has the colour of its value, also at the ends of the scale."""
        with browser.Browser(page_of(runs.seedling())) as shown, load(runs.seedling()) as result:
            shown.choose("tree", False)
            shown.choose("colour", "radius")  # All radii are equal: the scale's lower end.
            self.assertEqual(self.middles(shown, result), {(0x44, 0x01, 0x54)})
            shown.choose("colour", "potential")
            shown.choose("low", -2e9), shown.choose("high", -1e9)  # All values are beyond the upper end.
            self.assertEqual(len(self.middles(shown, result)), 1)

    def middles(self, shown, result):
        pixels = shown.value("""(() => {
            const source = document.getElementById("scene"), copy = document.createElement("canvas");
            [copy.width, copy.height] = [source.width, source.height];
            copy.getContext("2d").drawImage(source, 0, 0);
            return [copy.width, copy.height, Array.from(copy.getContext("2d").getImageData(0, 0, copy.width, copy.height).data)];
        })()""")
        width, height, data = pixels
        image = np.array(data, np.uint8).reshape(height, width, 4)
        positions = np.asarray(result.frame()["position"])[:, :2]
        scale = min(width, height) / (1.04 * 0.017)
        columns = np.int64(width / 2 + (positions[:, 0] - 0.0085) * scale)
        rows = np.int64(height / 2 - (positions[:, 1] - 0.0085) * scale)
        return {tuple(int(c) for c in image[row, column, :3]) for row, column in zip(rows, columns)}

    def test_grains_in_space(self):
        with browser.Browser(page_of(runs.gas())) as shown:
            before = shown.picture()
            for kind, x in [("mousePressed", 300), ("mouseMoved", 400), ("mouseReleased", 400)]:
                shown.call("Input.dispatchMouseEvent", type=kind, x=x, y=300, button="left", buttons=1, clickCount=1)
            self.assertNotEqual(shown.picture(), before)  # The view has rotated.
            shown.choose("colour", "cluster")
            self.assertIn("one colour a set", shown.value("document.getElementById('what').textContent"))
            self.assertEqual(shown.value("document.getElementById('title').textContent"), 'Few <grains> & "signs" t = 1 t0, N = 60')
            self.assertEqual(shown.complaints, [])

    def test_electrodes_in_space(self):
        with browser.Browser(page_of(runs.electrodes_in_space())) as shown:
            words = "thick grey: left side 9000 V, right side -9000 V; dark spheres: ball 1000 V"
            self.assertEqual(shown.value("document.getElementById('electrodes').textContent"), words)
            shown.choose("radius", 0.1)  # Only the ball is large and dark.
            self.assertGreater(self.dark_share(shown), 0.005)
            self.assertEqual(shown.complaints, [])

    def dark_share(self, shown):
        """Share of the picture's pixels with the colour of an electrode at any brightness."""
        return shown.value("""(() => {
            const source = document.getElementById("scene"), copy = document.createElement("canvas");
            [copy.width, copy.height] = [source.width, source.height];
            const context = copy.getContext("2d");
            context.drawImage(source, 0, 0);
            const pixels = context.getImageData(0, 0, copy.width, copy.height).data;
            let dark = 0;
            for (let i = 0; i < pixels.length; i += 4) dark += pixels[i] < 110 && pixels[i] === pixels[i + 1] && pixels[i] === pixels[i + 2];
            return dark / (pixels.length / 4);
        })()""")


if __name__ == "__main__":
    if not browser.PROGRAM:
        print("chromium is not installed: no page was opened in a browser")
        sys.exit(77)
    unittest.main()
