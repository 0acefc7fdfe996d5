"""Tests that the arrays in the page of a run are the run's. browser_check.py opens the page."""
import base64
import json
import os
import re
import unittest
import zlib

import numpy as np

import runs
from lichtenberg import load
from lichtenberg.ground import nearest_ground


def page_of(path, *options):
    out = runs.FOLDER / f"{os.path.basename(path)}.html"
    status, answer, complaint = runs.program("view", path, "--out", out, "--overwrite", *options)
    assert status == 0, complaint
    assert "MB" in answer
    return out


def stored(page):
    """Description of the run in the page, and its arrays."""
    text = page.read_text()
    read = lambda name: json.loads(re.search(f'id="{name}">(.*?)</script>', text, re.DOTALL).group(1))
    return read("about"), read("arrays")


def unpacked(text, size, row):
    """Decodes an array as view.js does."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(size, -1)
    differences = np.ascontiguousarray(planes.T).view(f"<u{size}").reshape(-1, row)
    return np.cumsum(differences, axis=0, dtype=f"u{size}")


class ResultViewTest(unittest.TestCase):
    def test_the_page_of_a_result_without_a_name_is_beside_it(self):
        with load(runs.seedling()) as result:
            page = result.view(overwrite=True)
        self.assertEqual(str(page), os.path.splitext(str(runs.seedling()))[0] + ".html")
        self.assertGreater(os.path.getsize(page), 0)


class ArraysTest(unittest.TestCase):
    def test_places_are_within_half_a_step(self):
        for path in (runs.seedling(), runs.gas()):
            about, arrays = stored(page_of(path))
            with load(path) as result:
                low, high = np.array(about["low"]), np.array(about["high"])
                steps = unpacked(arrays["places"], 2, 3 * result.count).reshape(len(result), -1, 3)
                # The corners have six digits, so their relative error is at most 5e-6.
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
            charge = next(column for column in about["columns"] if column["name"] == "charge")
            self.assertEqual((charge["low"], charge["high"]), result.colour_range("charge"))
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
        points = unpacked(arrays["ground"], 4, 1).view(np.float32)  # One row, so no differences are summed.
        row = zlib.decompress(base64.b64decode(arrays["ground"]))
        points = np.ascontiguousarray(np.frombuffer(row, np.uint8).reshape(4, -1).T).view("<f4").reshape(-1, 3)
        distance = np.hypot(points[:, 0] - 0.85e-2, points[:, 1])
        # 2^-13 of coordinates of at most a centimetre.
        np.testing.assert_allclose(distance, 1e-3, atol=2 * 1e-2 * 2**-13)

    def test_electrodes_in_space_are_there_and_ways_end_at_them(self):
        about, arrays = stored(page_of(runs.electrodes_in_space()))
        shapes = {electrode["name"]: electrode for electrode in about["electrodes"]}
        self.assertEqual((shapes["left side"]["low"], shapes["left side"]["high"]), ([0, 0, 0], [0, 0.02, 0.02]))
        self.assertEqual((shapes["right side"]["low"], shapes["right side"]["high"]), ([0.02, 0, 0], [0.02, 0.02, 0.02]))
        self.assertEqual(shapes["right side"]["potential"], -9000)
        self.assertEqual((shapes["ball"]["shape"], shapes["ball"]["radius"]), ("sphere", 3e-3))
        with load(runs.electrodes_in_space()) as result:
            touching = np.flatnonzero(result.frame(0)["successor"] == -1)
        self.assertEqual(touching.tolist(), [0, 1])
        row = zlib.decompress(base64.b64decode(arrays["ground"]))
        points = unpacked(arrays["ground"], 4, len(row) // 4).view(np.float32).reshape(-1, 3)
        # Directly above the ball and next to the side, to the 13 bits that are stored.
        np.testing.assert_allclose(points[:2], [[0.01, 0.008, 0.01], [0, 0.01, 0.012]], rtol=2**-12)

    def test_the_ground_is_the_nearest_surface_of_all(self):
        shapes = {
            "side": {"shape": "side", "ends": [0, 0, 10, 0]},
            "disk": {"shape": "disk", "centre": [2, 8], "radius": 1},
            "ring": {"shape": "ring", "centre": [5, 5], "radius": 5},
            "bar": {"shape": "bar", "from": [8, 4], "to": [8, 6], "width": 1},
        }
        nearest = {"side": ([1, 2], [1, 0]), "disk": ([2, 6], [2, 7]), "ring": ([5, 8], [5, 10]), "bar": ([6, 5], [7.5, 5])}
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
        self.assertEqual(stored(page)[0]["scene"], runs.gas_scene())

    def test_a_page_is_not_replaced_unless_told(self):
        page = page_of(runs.seedling())
        status, _, complaint = runs.program("view", runs.seedling(), "--out", page)
        self.assertEqual(status, 2)
        self.assertIn("give --overwrite", complaint)


if __name__ == "__main__":
    unittest.main()
