"""Tests that the arrays in the page of a run are the run's, and scales, camera and curves those of pictures. browser_check.py
opens the page."""
import base64
import html
import json
import os
import re
import shutil
import unittest
import zlib
from functools import cache

import h5py
import numpy as np

import runs
from lichtenberg import load
from lichtenberg.ground import nearest_ground
from lichtenberg.pictures import frames, series, space


@cache
def page_of(path, *options):
    out = runs.FOLDER / f"{os.path.basename(path)}{''.join(options)}.html"
    status, answer, complaint = runs.command("view", path, "--out", out, "--overwrite", *options)
    assert status == 0, complaint
    assert "MB" in answer
    return out


@cache
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


NORMAL = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "\N{MINUS SIGN}0123456789")


@cache
def svg_of(path, *options):
    """Texts in the picture that `plot` draws."""
    out = runs.FOLDER / "picture.svg"
    status, _, complaint = runs.command("plot", path, "--out", out, "--overwrite", *options)
    assert status == 0, complaint
    spans = re.sub(r"<tspan[^>]*>\s*|\s*</tspan>\s*", "", out.read_text())  # Powers are in several spans.
    return {html.unescape(text).strip() for text in re.findall(r"<text[^>]*>([^<]*)</text>", spans)}


class PictureTest(unittest.TestCase):
    """Scales, camera, captions and curves of the page are those of `plot`."""

    @runs.long
    def test_scales_have_range_label_and_ticks_of_plot(self):
        for path in (runs.seedling(), runs.gas(), runs.electrodes_in_space(), runs.packing()):
            about, _ = stored(page_of(path))
            run = frames.read_run(path)
            self.assertEqual([column["name"] for column in about["columns"]], list(run.quantities))
            for column in about["columns"][: None if path == runs.seedling() else 4]:
                words = svg_of(path, "--colour", column["name"])
                if column["kind"] == "category":
                    self.assertIn(f"colour: {column['label']}", words)
                    continue
                scale = frames.common_scale([run], column["name"])
                self.assertEqual((column["low"], column["high"]), (scale.low, scale.high))
                self.assertEqual(column["label"], column["bar"]["label"])
                self.assertIn(column["label"], words)
                ticks = {text.translate(NORMAL) for _, text in column["bar"]["ticks"]}
                self.assertLessEqual(ticks, words)

    @runs.long
    def test_colour_and_range_are_those_of_plot(self):
        for colour, own_range in [("charge", "-1e-12,4e-12"), ("force", "1e-9,1e-6"), ("potential", None), (None, "-20,30")]:
            options = [f"--colour={colour}"] * bool(colour) + [f"--range={own_range}"] * bool(own_range)
            about, _ = stored(page_of(runs.seedling(), *options))
            shown = next(column for column in about["columns"] if column["name"] == about["colour"])
            scale = frames.common_scale([frames.read_run(runs.seedling())], colour or about["colour"], own_range)
            self.assertEqual(about["colour"], colour or "potential")
            self.assertEqual((shown["low"], shown["high"], shown["beyond"]), (scale.low, scale.high, scale.beyond))
            words = svg_of(runs.seedling(), *options)
            self.assertLessEqual({text.translate(NORMAL) for _, text in shown["bar"]["ticks"]}, words)
            plain = stored(page_of(runs.seedling()))[0]["columns"]  # Other columns keep their scales.
            others = [[column for column in each if column["name"] != about["colour"]] for each in (about["columns"], plain)]
            self.assertEqual(*others)

    def test_wrong_colours_and_ranges_have_the_message_of_plot(self):
        for options in ("--colour=volume", "--range=5,-5", "--range=5", "--range=0,inf", "--colour=cluster --range=0,1",
                        "--colour=force --range=-1,1"):  # fmt: skip
            refused = [runs.command(command, *options.split(" "), runs.seedling()) for command in ("view", "plot")]
            self.assertEqual(refused[0], refused[1])
            self.assertEqual(refused[0][0], 2)

    def test_range_is_that_of_the_run_for_any_frames(self):
        for path in (runs.seedling(), runs.gas()):
            whole, part = (stored(page_of(path, *options))[0]["columns"] for options in ([], ["--frames", "0"]))
            for one, other in zip(whole, part):
                self.assertEqual({**one, "changes": False}, {**other, "changes": False})

    def test_camera_is_that_of_plot(self):
        for path in (runs.gas(), runs.electrodes_in_space()):
            camera = stored(page_of(path))[0]["camera"]
            run = frames.read_run(path)
            expected = space.Camera(run.window[1], run.down)
            turn, rise, size = camera["turn"], camera["rise"], np.subtract(*camera["box"][::-1])
            right = np.array([np.cos(turn), 0, -np.sin(turn)])
            up = np.array([-np.sin(rise) * np.sin(turn), np.cos(rise), -np.sin(rise) * np.cos(turn)])
            np.testing.assert_allclose([right @ camera["frame"], up @ camera["frame"]], expected.axes[:2], atol=1e-15)
            np.testing.assert_allclose(size, run.window[1], rtol=1e-5)
            self.assertEqual(camera["distance"], expected.distance)
            np.testing.assert_allclose([camera["low"], camera["high"]], [expected.low, expected.high], rtol=5e-6)  # Six digits.
            self.assertLessEqual({label["text"] for label in camera["labels"]}, svg_of(path))

    @runs.long
    def test_captions_and_default_colour_are_those_of_plot(self):
        for path in (runs.seedling(), runs.gas(), runs.packing()):
            about, _ = stored(page_of(path))
            self.assertIn(about["captions"][-1], svg_of(path))
            status, answer, _ = runs.command("plot", path, "--out", "last.png", "--overwrite")
            self.assertEqual(status, 0)
            self.assertEqual(answer.split(" by ")[1:], [f"{about['colour']}\n"] if about["colour"] else [])

    def test_curves_have_axes_and_legends_of_plot(self):
        for path in (runs.seedling(), runs.gas(), runs.packing()):
            curves = stored(page_of(path))[0]["curves"]
            words = svg_of(path, "--series")
            count = len(series.panels_of([series.read(path)], None))
            for panel in curves[:count]:
                self.assertLessEqual({axis["label"] for axis in panel["axes"]}, words)
                self.assertLessEqual({curve["label"] for curve in panel["curves"]} - {""}, words)
            for panel in curves:
                self.assertTrue(all(axis["label"] and axis["ticks"] for axis in panel["axes"]))
                self.assertTrue(len(panel["curves"]) == 1 or all(curve["label"] for curve in panel["curves"]))

    def test_values_that_are_equal_or_no_numbers_have_a_scale(self):
        for value, (low, high) in {2e-12: (0, 2e-12), 0: (0, 1), np.nan: (0, 1), -3e-12: (-3e-12, 0)}.items():
            path = altered(runs.seedling(), f"all-{value}", lambda charge: np.full_like(charge, value))
            column = next(c for c in stored(page_of(path))[0]["columns"] if c["name"] == "charge")
            self.assertEqual((column["low"], column["high"]), (low, high))
            self.assertIn(column["label"], svg_of(path, "--colour", "charge"))

    def test_a_frame_without_bodies_is_shown(self):
        path = altered(runs.seedling(), "none", None)
        about, _ = stored(page_of(path))
        self.assertEqual(about["captions"][-1], "t = 0.3 s, N = 0")
        self.assertIn(about["captions"][-1], svg_of(path, "--colour", "charge"))


def altered(path, name, change):
    """Copy of a result with the charges that `change` returns; without bodies if it is None."""
    copy = str(runs.FOLDER / f"{name}.h5")
    shutil.copy(path, copy)
    with h5py.File(copy, "r+") as file:
        particles = file["particles/conductors"]
        count = len(particles["radius"])
        names = []
        particles.visititems(lambda name, data: names.append(name) if isinstance(data, h5py.Dataset) else None)
        for name in ["charge/value"] if change else names:
            values, attributes = particles[name][()], dict(particles[name].attrs)
            axis = next((k for k in (0, 1) if values.ndim > k and values.shape[k] == count), None)
            if axis is None:
                continue
            del particles[name]
            particles[name] = change(values) if change else values.take([], axis)
            particles[name].attrs.update(attributes)
    return copy


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
            clusters = unpacked(arrays["column cluster"], 4, 36).view(np.int32)
            for numbers, group in zip(clusters, np.asarray(result["group"])):
                _, inverse, size = np.unique(group, return_inverse=True, return_counts=True)
                np.testing.assert_array_equal(numbers[size[inverse] > 1], group[size[inverse] > 1] + 1)
                self.assertEqual(set(numbers[size[inverse] == 1]), {-(2**31)})
        names = [column["name"] for column in about["columns"]]
        for name in ("potential", "charge", "force", "cluster", "strahler", "connection_time", "speed", "radius"):
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
            "polygon": {"shape": "polygon", "points": [[3, 3], [5, 3], [5, 5], [3, 5]]},
        }
        nearest = {"side": ([1, 2], [1, 0]), "disk": ([2, 6], [2, 7]), "ring": ([5, 8], [5, 10]), "bar": ([6, 5], [7.5, 5]),
                   "polygon": ([5.5, 4], [5, 4])}
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
