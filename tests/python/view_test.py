"""The page of a run: its arrays are the run's, and Chromium shows it without a complaint, if it is installed."""
import base64
import json
import os
import re
import unittest
import zlib

import numpy as np

import browser
import runs
from lichtenberg import load
from lichtenberg.view import nearest_ground


def page_of(path, *options):
    out = runs.FOLDER / f"{os.path.basename(path)}.html"
    status, answer, complaint = runs.program("view", path, "--out", out, "--overwrite", *options)
    assert status == 0, complaint
    assert "MB" in answer
    return out


def stored(page):
    """What the page says of the run, and its arrays."""
    text = page.read_text()
    read = lambda name: json.loads(re.search(f'id="{name}">(.*?)</script>', text, re.DOTALL).group(1))
    return read("about"), read("arrays")


def unpacked(text, size, row):
    """As view.js does."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(size, -1)
    differences = np.ascontiguousarray(planes.T).view(f"<u{size}").reshape(-1, row)
    return np.cumsum(differences, axis=0, dtype=f"u{size}")


class ArraysTest(unittest.TestCase):
    def test_places_are_within_half_a_step(self):
        for path in (runs.seedling(), runs.gas()):
            about, arrays = stored(page_of(path))
            with load(path) as result:
                low, high = np.array(about["low"]), np.array(about["high"])
                steps = unpacked(arrays["places"], 2, 3 * result.count).reshape(len(result), -1, 3)
                # The corners have six digits, so that they may be off by 5e-6 of themselves.
                allowed = (high - low) / 65535 / 2 + 5e-6 * np.maximum(abs(low), abs(high))
                off = np.abs(low + steps / 65535 * (high - low) - result["position"])
                self.assertTrue((off <= allowed * (1 + 1e-9)).all())

    def test_columns_have_thirteen_binary_digits(self):
        about, arrays = stored(page_of(runs.seedling()))
        with load(runs.seedling()) as result:
            bits = unpacked(arrays["column charge"], 4, 36)
            np.testing.assert_allclose(bits.view(np.float32), result["charge"], rtol=2**-13 + 2**-24)
            groups = unpacked(arrays["column group"], 4, 36).view(np.int32)
            np.testing.assert_array_equal(groups, result["group"])
        names = [column["name"] for column in about["columns"]]
        for name in ("potential", "charge", "speed", "|force|", "group", "connected", "first joined the tree at", "radius"):
            self.assertIn(name, names)

    def test_edges_are_contacts_and_tree(self):
        about, arrays = stored(page_of(runs.seedling(), "--frames", "1:"))
        self.assertEqual(about["frames"], [1, 2, 3])
        with load(runs.seedling()) as result:
            for kind, pairs in [("contacts", lambda f: f.contacts), ("tree", lambda f: f.tree)]:
                expected = np.concatenate([pairs(result.frame(k)) for k in (1, 2, 3)])
                count = about[kind][-1]
                np.testing.assert_array_equal(unpacked(arrays[kind], 4, count).view(np.int32).T, expected)

    def test_the_ground_is_met_at_the_electrode_s_surface(self):
        _, arrays = stored(page_of(runs.seedling()))
        points = unpacked(arrays["ground"], 4, 1).view(np.float32)  # one row, so nothing is summed
        row = zlib.decompress(base64.b64decode(arrays["ground"]))
        points = np.ascontiguousarray(np.frombuffer(row, np.uint8).reshape(4, -1).T).view("<f4").reshape(-1, 3)
        distance = np.hypot(points[:, 0] - 0.85e-2, points[:, 1])
        # 2^-13 of coordinates of a centimetre at most.
        np.testing.assert_allclose(distance, 1e-3, atol=2 * 1e-2 * 2**-13)

    def test_the_ground_is_the_nearest_surface_of_all(self):
        shapes = {
            "side": {"shape": "side", "ends": [0, 0, 10, 0]},
            "disk": {"shape": "disk", "centre": [2, 8], "radius": 1},
            "ring": {"shape": "ring", "centre": [5, 5], "radius": 5},
            "bar": {"shape": "bar", "from": [8, 4], "to": [8, 6], "width": 1},
        }
        nearest = {"side": ([1, 2, 0], [1, 0, 0]), "disk": ([2, 6, 0], [2, 7, 0]), "ring": ([5, 8, 0], [5, 10, 0]), "bar": ([6, 5, 0], [7.5, 5, 0])}
        for name, (point, expected) in nearest.items():
            np.testing.assert_allclose(nearest_ground(np.array([point], float), [shapes[name]])[0], expected, atol=1e-14)
        points, expected = (np.array(each, float) for each in zip(*(nearest[name] for name in ("side", "disk", "bar"))))
        electrodes = [shapes[name] for name in ("side", "disk", "bar")]
        np.testing.assert_allclose(nearest_ground(points, electrodes), expected, atol=1e-14)

    def test_nothing_is_fetched_and_no_text_ends_the_page(self):
        page = page_of(runs.gas())
        text = page.read_text()
        self.assertEqual(re.findall(r"(?:src|href|url)\s*[=(]|https?:|fetch\(", text), [])
        self.assertIn("<title>Few &lt;grains&gt; &amp; &quot;signs&quot;</title>", text)
        self.assertEqual(stored(page)[0]["title"], 'Few <grains> & "signs"')
        self.assertEqual(stored(page)[0]["scene"], runs.GAS)

    def test_a_page_is_not_replaced_unless_told(self):
        page = page_of(runs.seedling())
        status, _, complaint = runs.program("view", runs.seedling(), "--out", page)
        self.assertEqual(status, 2)
        self.assertIn("allow --overwrite", complaint)


@unittest.skipUnless(browser.PROGRAM, "chromium is not installed")
class BrowserTest(unittest.TestCase):
    def test_a_tree_in_the_plane(self):
        with browser.Browser(page_of(runs.seedling())) as shown:
            self.assertEqual(shown.value("document.getElementById('now').textContent"), "0.3 s, frame 3")
            pictures = [shown.picture()]
            for control, value in [("frame", 0), ("colour", "charge"), ("contacts", True), ("radius", 0.5), ("log", True)]:
                shown.choose(control, value)
                pictures.append(shown.picture())
            self.assertEqual(len(set(pictures)), len(pictures))  # each changed what is seen
            self.assertEqual(shown.value("document.getElementById('now').textContent"), "0 s, frame 0")
            shown.value("document.getElementById('play').click()")
            shown.wait_for("document.getElementById('frame').value > 1")
            self.assertEqual(shown.complaints, [])

    def test_colours_are_those_of_the_scale(self):
        """The pixel in the middle of each particle has the colour of its value, at the ends of the scale too."""
        with browser.Browser(page_of(runs.seedling())) as shown, load(runs.seedling()) as result:
            shown.choose("tree", False)
            shown.choose("colour", "radius")  # all the same: the scale's lower end
            self.assertEqual(self.middles(shown, result), {(0x44, 0x01, 0x54)})
            shown.choose("colour", "potential")
            shown.choose("low", -2e9), shown.choose("high", -1e9)  # all are beyond the upper end
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
        places = np.asarray(result.frame()["position"])[:, :2]
        scale = min(width, height) / (1.04 * 0.017)
        columns = np.int64(width / 2 + (places[:, 0] - 0.0085) * scale)
        rows = np.int64(height / 2 - (places[:, 1] - 0.0085) * scale)
        return {tuple(int(c) for c in image[row, column, :3]) for row, column in zip(rows, columns)}

    def test_grains_in_space(self):
        with browser.Browser(page_of(runs.gas())) as shown:
            before = shown.picture()
            for kind, x in [("mousePressed", 300), ("mouseMoved", 400), ("mouseReleased", 400)]:
                shown.call("Input.dispatchMouseEvent", type=kind, x=x, y=300, button="left", buttons=1, clickCount=1)
            self.assertNotEqual(shown.picture(), before)  # turned
            shown.choose("colour", "cluster")
            self.assertIn("one colour a set", shown.value("document.getElementById('what').textContent"))
            self.assertEqual(shown.value("document.getElementById('title').textContent"), 'Few <grains> & "signs" t = 1 t0, N = 60')
            self.assertEqual(shown.complaints, [])


if __name__ == "__main__":
    unittest.main()
