"""Checks that Chromium shows the page of a run without errors. If Chromium is not installed, the exit status is 77,
which ctest reports as skipped."""
import base64
import io
import sys
import unittest
from unittest import mock

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread

import browser
import runs
from lichtenberg import load
from lichtenberg.pictures import frames, space
from view_test import page_of, stored


class BrowserTest(unittest.TestCase):
    def test_a_tree_in_the_plane(self):
        with browser.Browser(page_of(runs.seedling())) as shown:
            self.assertEqual(shown.value("document.getElementById('now').textContent"), "t = 0.3 s, frame 3")
            pictures = [shown.picture()]
            for control, value in [("frame", 0), ("colour", "charge"), ("contacts", True), ("radius", 0.5), ("log", True)]:
                shown.choose(control, value)
                pictures.append(shown.picture())
            self.assertEqual(len(set(pictures)), len(pictures))  # Each change is visible.
            self.assertEqual(shown.value("document.getElementById('now').textContent"), "t = 0 s, frame 0")
            shown.value("document.getElementById('play').click()")
            shown.wait_for("document.getElementById('frame').value > 1")
            self.assertEqual(shown.complaints, [])

    def test_colours_are_those_of_the_picture(self):
        """In the middle of each particle the page has the colour of the picture, within the rounding of stored values."""
        run = frames.read_run(runs.seedling())
        with browser.Browser(page_of(runs.seedling())) as shown:
            shown.choose("tree", False)
            for name in run.quantities:
                shown.choose("colour", name)
                self.compare(shown, run, name, None)
            for name, own_range in [("potential", (-300, 100)), ("charge", (1e-11, 3e-11)), ("force", (1e-8, 1e-6)),
                                    ("strahler", (1, 5)), ("connection_time", (0.05, 0.1))]:  # fmt: skip
                factor = frames.common_scale([run], name).factor_and_label[0]
                shown.choose("colour", name)
                shown.choose("high", own_range[1] * factor), shown.choose("low", own_range[0] * factor)
                self.assertEqual(shown.value("document.getElementById('refusal').textContent"), "")
                self.compare(shown, run, name, own_range)
            self.assertEqual(shown.complaints, [])

    def compare(self, shown, run, name, own_range):
        scale = frames.common_scale([run], name, own_range and f"{own_range[0]},{own_range[1]}")
        image = self.pixels(shown)
        height, width = image.shape[:2]
        unit = min(width / 1.04 / run.size[0], height / 1.04 / run.size[1])  # pixels per mm
        pictures = frames.Pictures([run], scale, name)
        with mock.patch("lichtenberg.pictures.drawing.draw_edges"):  # paths hide the middles
            pictures.draw([3])
        canvas = FigureCanvasAgg(pictures.layout.figure)
        canvas.draw()
        drawn = np.asarray(canvas.buffer_rgba())
        with load(runs.seedling()) as result:
            values = run.values(result.file, name, 3)
            position = np.asarray(result.frame(3)["position"])[:, :2] * 1e3
        at = np.int64(pictures.layout.panels[0].transData.transform(position))
        # The page stores values with 13 binary digits: colours of an interval, each with one step of 8 bits.
        near = [np.int64(np.round(255 * scale.colours(values * (1 + share)))) for share in (-(2.0**-12), 0, 2.0**-12)]
        low, high = np.min(near, axis=0)[:, :3] - 1, np.max(near, axis=0)[:, :3] + 1
        for i in range(len(position)):
            page = image[int(height / 2 - (position[i, 1] - run.size[1] / 2) * unit), int(width / 2 + (position[i, 0] - run.size[0] / 2) * unit)]
            picture = np.int64(drawn[len(drawn) - 1 - at[i, 1], at[i, 0], :3])
            for colour in (page, picture):
                self.assertTrue((low[i] <= colour).all() and (colour <= high[i]).all(), (name, i, values[i], page, picture))

    def pixels(self, shown):
        """[height, width, 3] colours of the scene."""
        address = shown.value("document.getElementById('scene').toDataURL()")
        return np.int64(np.round(255 * imread(io.BytesIO(base64.b64decode(address.split(",")[1])))[..., :3]))

    def test_impossible_ranges_are_refused(self):
        with browser.Browser(page_of(runs.seedling())) as shown:
            shown.choose("colour", "force")
            before = self.pixels(shown)
            for control, value, words in [("low", 1e9, "the first is less than the second"), ("low", "", "needs two numbers"),
                                          ("low", 0, "must begin above 0: force is drawn by decades")]:  # fmt: skip
                shown.choose(control, value)
                self.assertIn(words, shown.value("document.getElementById('refusal').textContent"))
                np.testing.assert_array_equal(self.pixels(shown), before)

    def test_legend_and_axes_have_the_ticks_of_the_page(self):
        page = page_of(runs.seedling())
        columns, curves = (stored(page)[0][name] for name in ("columns", "curves"))
        with browser.Browser(page) as shown:
            for column in columns:
                shown.choose("colour", column["name"])
                texts = shown.value("[...document.querySelectorAll('#scale-bar .tick')].map((tick) => tick.textContent)")
                self.assertEqual(texts, [text for _, text in column.get("bar", {"ticks": []})["ticks"]])
            shown.value("window.texts = []; CanvasRenderingContext2D.prototype.fillText = (text) => { texts[texts.length] = text; }")
            for logarithmic in (False, True):
                shown.value("window.texts.length = 0")
                shown.choose("log", logarithmic)
                axes = [panel.get("logarithmic" if logarithmic else "axes", panel["axes"]) for panel in curves]
                expected = [text for pair in axes for axis in pair for text in [axis["label"], *(t for _, t in axis["ticks"])]]
                self.assertLessEqual(set(expected) - {axis["label"] for _, axis in axes}, set(shown.value("window.texts")))
            headings = shown.value("document.getElementById('curves').textContent")
            for panel in curves:
                for words in [panel["axes"][1]["label"], *(curve["label"] for curve in panel["curves"])]:
                    self.assertIn(words, headings)

    def test_spheres_have_place_and_colour_of_the_picture(self):
        """The pixel of each centre has the colour that the picture has there."""
        run = frames.read_run(runs.electrodes_in_space())
        camera, scale = space.Camera(run.box, run.down), frames.common_scale([run], "potential")
        with load(runs.electrodes_in_space()) as result:
            position = np.asarray(result.frame(2)["position"])
            faces = scale.colours(run.values(result.file, "potential", 2))
        with browser.Browser(page_of(runs.electrodes_in_space())) as shown:
            shown.choose("tree", False)
            image = self.pixels(shown)
        height, width = image.shape[:2]
        unit = min(width / camera.size[0], height / camera.size[1])  # pixels per metre in the middle
        seen = camera.project(position) - (camera.low + camera.high) / 2
        rendered = space.rendered(camera, position, run.radius, faces, pixels=1000)
        fine = 1000 / camera.size.max()
        for i in range(len(position)):
            page = image[int(height / 2 - seen[i, 1] * unit), int(width / 2 + seen[i, 0] * unit)]
            at = np.int64((camera.project(position[i]) - camera.low) * fine)
            picture = 255 * rendered[at[1], at[0], :3]
            # Each pixel is up to half a diagonal off the centre. The light changes by up to 0.62 |LIGHT in the picture| times
            # that distance in radii. Each colour is rounded by up to one step.
            radius = run.radius[i] * camera.scale(position[i])
            allowed = 255 * 0.62 * np.hypot(*space.LIGHT[:2]) * np.sqrt(0.5) * (1 / unit + 1 / fine) / radius + 2
            self.assertLessEqual(np.abs(page - picture).max(), allowed, (i, page, picture))

    def test_grains_in_space(self):
        with browser.Browser(page_of(runs.gas())) as shown:
            before = shown.picture()
            for kind, x in [("mousePressed", 300), ("mouseMoved", 400), ("mouseReleased", 400)]:
                shown.call("Input.dispatchMouseEvent", type=kind, x=x, y=300, button="left", buttons=1, clickCount=1)
            self.assertNotEqual(shown.picture(), before)  # The view has rotated.
            shown.choose("colour", "cluster")
            self.assertEqual(shown.value("document.getElementById('what').textContent"), "colour: grains in contact")
            title = shown.value("document.getElementById('title').textContent")
            self.assertIn('Few <grains> & "signs" t = 1 t₀, N = 60', title)
            self.assertEqual(shown.complaints, [])

    def test_electrodes_in_space(self):
        with browser.Browser(page_of(runs.electrodes_in_space())) as shown:
            words = "left side 9 kV, right side -9 kV, ball 1 kV"
            self.assertEqual(shown.value("document.getElementById('marks').textContent"), words)
            shown.choose("radius", 0.1)  # Only the ball is large and dark.
            self.assertGreater(self.dark_share(shown), 0.005)
            self.assertEqual(shown.complaints, [])

    def dark_share(self, shown):
        """Share of the picture's pixels with the colour of an electrode at any brightness."""
        image = self.pixels(shown)
        return ((image[..., 0] < 110) & (np.ptp(image, axis=2) == 0)).mean()


if __name__ == "__main__":
    if not browser.PROGRAM:
        print("chromium is not installed: no page was opened in a browser")
        sys.exit(77)
    unittest.main()
