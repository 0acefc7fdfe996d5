"""Tests of plot and film: sizes, colours, text, and no file replaced silently."""
import os
import shutil
import subprocess
import unittest
from functools import cache

import numpy as np
from matplotlib.image import imread

import runs
from lichtenberg import load
from lichtenberg.pictures import drawing, packing

# Two plates at +-10 kV and a sphere that moves from one to the other: 6 frames, 20 ms.
PLATES = """
title = "Plates"
[domain]
size = [8e-3, 8e-3]
left = { potential = 10e3 }
right = { potential = -10e3 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [0.6e-3, 4e-3]
radius = 0.6e-3
[effects.floating_conductors]
[effects.stokes_drag]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 6e-6
[field]
cells = 32
[output]
every = 0.004
picture = false
[stop]
time = 0.02
stationary = false
"""

# Three charged spheres in a row that touch the ground and each other. All are at 0 V from the start.
CHAIN = """
title = "Chain"
[domain]
size = [8e-3, 8e-3]
bottom = { potential = 0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [4e-3, 0.55e-3]
radius = 0.5e-3
[[conductor]]
position = [4e-3, 1.6e-3]
radius = 0.5e-3
[[conductor]]
position = [4e-3, 2.65e-3]
radius = 0.5e-3
[effects.floating_conductors]
[effects.current_injection]
current = 1e-12
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 0.2e-3
[field]
cells = 32
[output]
every = 0.004
picture = false
[stop]
time = 0.012
stationary = false
"""

SPACE = """
[domain]
size = [10.0, 10.0, 10.0]
[[conductor]]
position = [5.0, 5.0, 8.0]
radius = 1.9
[[conductor]]
position = [2.3, 3.15, 2.96]
velocity = [1.0, 0.0, 0.0]
radius = 1.0
[effects.hertz_contact]
[output]
every = 1e-3
picture = false
[stop]
time = 1e-3
stationary = false
"""

made = cache(runs.made)


def pixel(picture, x, y):
    """Colour at the fractions x and y of width and height from the lower left of a square panel. The panel is 5 inches wide and
    starts at (0.22, 0.4) of 6.24 x 6.02 inches; a narrower panel occupies less."""
    height, width = picture.shape[:2]
    return picture[int((6.02 - 0.4 - 5 * y) / 6.02 * height), int((0.22 + 5 * x) / 6.24 * width)]


class PicturesTest(unittest.TestCase):
    """Each test has a folder with a result scene.h5 and the scene scene.toml."""

    SCENE = PLATES

    def setUp(self):
        self.folder = runs.FOLDER / self.id().rpartition(".")[2]
        self.folder.mkdir()
        shutil.copy(made(type(self).__name__, self.SCENE), self.folder / "scene.h5")
        (self.folder / "scene.toml").write_text(self.SCENE)

    def run_without_error(self, *words, command=runs.command):
        """Returns the output of a command: by default in this process, or of `runs.program`."""
        status, said, complaint = command(*words, folder=self.folder)
        self.assertEqual(status, 0, complaint)
        return said

    def check_refused(self, sentence, *words, command=runs.command):
        status, _, complaint = command(*words, folder=self.folder)
        self.assertEqual(status, 2, complaint)
        self.assertIn(sentence, complaint)
        self.assertEqual(complaint.count("\n"), 1, complaint)

    def shell(self, command):
        """Ended process of a shell command, with LICHTENBERG replaced by the program."""
        words = command.replace("LICHTENBERG", f"'{runs.PROGRAM}'")
        return subprocess.run(words, shell=True, capture_output=True, text=True, cwd=self.folder, check=False)

    def picture(self, name):
        """Colours [height][width][red, green, blue] from 0 to 1, with row 0 at the top."""
        return imread(self.folder / name)[..., :3]

    def text(self, name):
        return (self.folder / name).read_text()


class Plates(PicturesTest):
    def test_frames_have_equal_layout_and_colour_scale_and_show_their_field(self):
        drawn = self.run_without_error("plot", "scene.h5", "--frames", "0,2:4:2")
        self.assertEqual(drawn, "".join(f"scene-frame-{k}-potential.png shows frame {k} by potential\n" for k in (0, 2, 4)))
        first, last = (self.picture(f"scene-frame-{k}-potential.png") for k in (0, 4))
        for picture in (first, last):
            self.assertEqual(picture.shape[:2], (1204, 1248))  # 6.24 x 6.02 inches at 200 points per inch.
            # Positive is red and negative is blue, darker near the plates. The ends of RdBu are 0.40, 0.00, 0.12 and 0.02,
            # 0.19, 0.38.
            left, right = pixel(picture, 0.02, 0.9), pixel(picture, 0.98, 0.9)
            self.assertAlmostEqual(left[0], 0.45, delta=0.09)
            self.assertLess(left[2], 0.2)
            self.assertAlmostEqual(right[2], 0.45, delta=0.09)
            self.assertLess(right[0], 0.1)
        # The colour bar and its labels, right of the panel, are the same.
        np.testing.assert_array_equal(first[200:, 1060:], last[200:, 1060:])
        # An open range starts at the first frame or ends at the last, for any step.
        said = self.run_without_error("plot", "scene.h5", "--frames", ":1,5::2147483647", "--colour", "speed")
        self.assertIn("shows frame 5 by speed", said)
        self.assertTrue((self.folder / "scene-frame-0-speed.png").exists())

    def test_the_picture_of_a_run_shows_its_field(self):
        # The field of the file is on the scene's 32 cells. The field solved again on 256 cells differs only near the sphere, in
        # 5 % of the picture, by at most 10 % of the colour range.
        words = ("run", "scene.toml", "--overwrite", "--quiet", "--set", "output.picture=true")
        self.run_without_error(*words, command=runs.program)
        self.run_without_error("plot", "scene.h5", "--frames", "4,5", "--out", "solved.png")
        field = self.picture("scene.png")[200:1000, 60:1000]
        difference = [np.abs(field - self.picture(f"solved-{k}.png")[200:1000, 60:1000]).mean() for k in (4, 5)]
        self.assertLess(difference[1], 0.005)
        self.assertGreater(difference[0], 0.005)  # The sphere has another position there.

    def test_frames_without_ends_are_every_fifth(self):
        self.assertEqual(self.run_without_error("plot", "scene.h5", "--frames", "::5", "--out", "a.png"),
                         "a-0.png shows frame 0 by potential\na-5.png shows frame 5 by potential\n")

    def test_options_set_text_in_svg_and_colours_in_png_and_a_pdf_is_written(self):
        self.run_without_error("plot", "scene.h5", "--frame", "1", "--out", "a.svg", "--range=-20e3,5e3")
        words = self.text("a.svg")
        for word in ("potential (kV)", "Plates", "t = 0.004 s, N = 1", "connected to an electrode", "1 mm"):
            self.assertIn(word, words)
        self.assertNotIn("ground", words)
        self.assertNotIn(">10<", words)  # The colour bar ends at 5 kV.
        self.assertIn("20<", words)
        self.run_without_error("plot", "scene.h5", "--out", "a.pdf")
        self.assertEqual((self.folder / "a.pdf").read_bytes()[:4], b"%PDF")
        # viridis ends in purple and yellow: 0.27, 0.00, 0.33 and 0.99, 0.91, 0.14.
        self.run_without_error("plot", "scene.h5", "--cmap", "viridis", "--out", "viridis.png")
        self.assertGreater(pixel(self.picture("viridis.png"), 0.01, 0.9)[1], 0.8)
        self.assertLess(pixel(self.picture("viridis.png"), 0.99, 0.9)[1], 0.1)
        for colour in ("charge", "force", "cluster", "speed"):
            self.run_without_error("plot", "scene.h5", "--colour", colour)
            # There is no field in the background.
            self.assertEqual(pixel(self.picture(f"scene-frame-5-{colour}.png"), 0.5, 0.8).min(), 1)

    def test_existing_pictures_are_replaced_only_with_overwrite(self):
        self.run_without_error("plot", "scene.h5")
        self.check_refused("scene-frame-5-potential.png exists: give --out another name, or give --overwrite", "plot", "scene.h5")
        self.run_without_error("plot", "scene.h5", "--overwrite")
        self.run_without_error("plot", "scene.h5", "--series")
        self.check_refused("scene-series.png exists", "plot", "scene.h5", "--series")
        (self.folder / "link.png").symlink_to("scene.toml")
        self.check_refused("link.png is no plain file", "plot", "scene.h5", "--out", "link.png", "--overwrite")
        self.assertEqual(self.text("scene.toml"), PLATES)

    def test_a_run_replaces_only_its_own_files(self):
        scene = PLATES.replace("picture = false", "").replace("time = 0.02", "time = 0.004")
        (self.folder / "other.toml").write_text(scene)
        (self.folder / "other.png").write_text("mine")
        words = ("run", "other.toml", "--quiet")
        self.check_refused("other.png exists, where the run writes its picture", *words, command=runs.program)
        self.assertEqual(self.text("other.png"), "mine")
        self.assertFalse((self.folder / "other.h5").exists())
        self.run_without_error(*words, "--overwrite", command=runs.program)
        self.assertEqual((self.folder / "other.png").read_bytes()[:4], b"\x89PNG")

    REFUSED = {
        "plot scene.h5 --range 5,-5": "--range 5,-5 is reversed",
        "plot scene.h5 --range 5": "--range 5 is not valid: it must be two numbers",
        "plot scene.h5 --range 0,inf": "both ends must be finite",
        "plot scene.h5 --colour force --range=-1,1": "force is drawn by decades, from above 0",
        "plot scene.h5 --colour cluster --range 0,1": "do not apply to the colour cluster",
        "plot scene.h5 --cmap rainbows": "--cmap rainbows is no colour map",
        "plot scene.h5 --colour current": "scene.h5 has no current by conductor",
        "plot scene.h5 --frame 6": "frame 6 is not in scene.h5: it has frames 0 to 5",
        "plot scene.h5 --frames 0,7": "frame 7 is not in scene.h5",
        "plot scene.h5 --frames 4:2": "4:2 is reversed",
        "plot scene.h5 --frames 0:5:0": "the step `0` must be a whole number from 1 on",
        "plot scene.h5 --frames first": "`first` is not a frame",
        "plot scene.h5 --frames 0,": "`` is not a frame",
        "plot scene.h5 --out nowhere/a.png": "nowhere/a.png cannot be written: there is no folder",
        "plot scene.h5 --out a.gif": "its name must end in .png, .pdf or .svg",
        "plot scene.h5 --cut z=1": "--cut is for scenes in space",
        "plot scene.h5 --series --colour charge": "are for pictures of frames, not for curves",
        "plot scene.h5 --series --observables energy,volume": "scene has not recorded volume: it has ",
        "plot scene.h5 --observables energy": "it needs --series",
        "film scene.h5 --out a.avi": "films are written as .mp4",
        "film scene.h5 --rate 1e-9": "--rate 1e-09 is not allowed: it must be from 0.1 to 1000",
        "film scene.h5 --frames 3:9": "frame 9 is not in scene.h5",
        "film scene.h5 --range 2,1": "--range 2,1 is reversed",
    }
    # The program refuses these before it starts Python.
    REFUSED_BY_THE_PROGRAM = {
        "plot scene.h5 --frame 1 --frames 2": "--frame and --frames say the same",
        "film scene.h5 --rate 0": "--rate: 0 is not allowed: it must be a number above 0",
        "plot pipe.h5": "pipe.h5 is no file: name a result file",
        "film pipe.h5": "pipe.h5 is no file: name a result file",
        "view pipe.h5": "pipe.h5 is no file: name a result file",
        "export --to csv pipe.h5": "pipe.h5 is no file: name a result file",
    }

    def test_impossible_requests_are_refused_with_a_message(self):
        for words, sentence in self.REFUSED.items():
            with self.subTest(words):
                self.check_refused(sentence, *words.split(" "))
        os.mkfifo(self.folder / "pipe.h5")
        for words, sentence in self.REFUSED_BY_THE_PROGRAM.items():
            with self.subTest(words):
                self.check_refused(sentence, *words.split(" "), command=runs.program)
        self.assertFalse((self.folder / "scene.mp4").exists())
        # Another user owns this folder; root can write everywhere.
        if os.geteuid() != 0:
            self.check_refused("cannot be written", "plot", "scene.h5", "--out", "/proc/a.png")

    def test_a_film_that_exists_stays(self):
        (self.folder / "scene.mp4").write_text("mine")
        self.check_refused("scene.mp4 exists: give --out another name, or give --overwrite", "film", "scene.h5")
        without = self.shell("PATH=/nowhere LICHTENBERG film scene.h5 --overwrite")
        self.assertEqual(without.returncode, 2)
        self.assertIn("there is no ffmpeg, which makes films of pictures: install Debian's package ffmpeg", without.stderr)
        self.assertEqual(self.text("scene.mp4"), "mine")

    @runs.long
    def test_file_names_with_a_colon_or_leading_dash_are_accepted(self):
        for name in ("a:b", "-c"):
            shutil.copy(self.folder / "scene.h5", self.folder / f"{name}.h5")
        self.run_without_error("plot", "--", "a:b.h5")
        self.run_without_error("plot", "--series", "--out", "series.png", "--", "a:b.h5", "-c.h5")
        # The program passes the words on.
        for words in ("film --quiet --frame 0 -- -c.h5", "film --quiet --frame 0 --out=-d:e.mp4 -- a:b.h5", "plot -- -c.h5",
                      "view -- -c.h5", "view -- a:b.h5"):  # fmt: skip
            self.run_without_error(*words.split(" "), command=runs.program)
        for name in ("-c.mp4", "-d:e.mp4", "-c.html", "a:b.html"):
            self.assertGreater((self.folder / name).stat().st_size, 0)

    @runs.long
    def test_an_unknown_mplbackend_in_the_environment_is_ignored(self):
        for command in ("plot scene.h5 --overwrite", "plot scene.h5 --series --overwrite"):
            ended = self.shell(f"MPLBACKEND=nonsense LICHTENBERG {command}")
            self.assertEqual(ended.returncode, 0, ended.stderr)
            self.assertNotIn("Traceback", ended.stderr)

    def test_an_interruption_of_a_film_leaves_no_file_and_prints_no_traceback(self):
        (self.folder / "ffmpeg").write_text(
            "#!/bin/sh\n>scene.mp4.partial-$PPID\nhead -c 100000 >/dev/null\nkill -INT $PPID\nexec cat >ffmpeg.log\n")
        (self.folder / "ffmpeg").chmod(0o755)
        ended = self.shell("PATH=.:$PATH env --default-signal=INT LICHTENBERG film scene.h5 --quiet")
        self.assertNotEqual(ended.returncode, 0)
        self.assertNotIn("Traceback", ended.stderr)
        self.assertFalse((self.folder / "scene.mp4").exists())
        self.assertEqual([path.name for path in self.folder.glob("*partial*")], [])

    @runs.long
    def test_each_frame_appears_once_with_170_pixels_per_inch_of_the_picture(self):
        made_film = self.run_without_error("film", "scene.h5", "--rate", "10")
        self.assertEqual(made_film, "scene.mp4 shows 6 frames by potential in 0.6 s\n")
        probe = "ffprobe -v error -count_frames -select_streams v -show_entries stream={} -of csv=p=0 "
        # 6.24 x 6.02 inches at 170 points per inch, rounded to even numbers.
        self.assertEqual(self.shell(probe.format("width,height,nb_read_frames,pix_fmt") + "scene.mp4").stdout,
                         "1060,1024,yuv420p,6\n")
        # The film has the colours of the pictures.
        self.assertEqual(self.shell("ffmpeg -v error -i scene.mp4 -frames:v 1 first.png").returncode, 0)
        left = pixel(self.picture("first.png"), 0.02, 0.9)
        self.assertGreater(left[0], 0.3)
        self.assertLess(left[2], 0.25)
        words = ("film", "scene.h5", "--frames", "1::2", "--colour", "charge", "--quiet")
        self.run_without_error(*words, command=runs.program)
        self.assertEqual(self.shell(probe.format("nb_read_frames") + "scene-charge.mp4").stdout, "3\n")

    @runs.long
    def test_curves_of_several_results_and_frames_side_by_side(self):
        shutil.copy(self.folder / "scene.h5", self.folder / "twin.h5")
        self.run_without_error("plot", "scene.h5", "--series", "--observables", "energy,charge_held", "--out", "curves.svg")
        self.assertIn("charge held", self.text("curves.svg"))
        self.run_without_error("plot", "scene.h5", "twin.h5", "--series", "--out", "both.svg")
        self.assertIn("twin", self.text("both.svg"))
        self.run_without_error("plot", "scene.h5", "twin.h5")
        # Two panels of 4.2 inches with 0.35 between them, and margins of 0.22 and 1.02.
        width = self.picture("scene-beside-twin-frame-5-potential.png").shape[1]
        self.assertAlmostEqual(width / (200 * 9.99), 1, delta=1e-3)

    def test_curves_of_an_ensemble(self):
        words = "ensemble scene.toml --vary medium.viscosity=0.5,0.7 --seeds 2 --out many --quiet"
        self.run_without_error(*words.split(" "), command=runs.program)
        self.run_without_error("plot", "many", "--series", "--out", "many.svg")
        self.assertIn("medium.viscosity = 0.5", self.text("many.svg"))
        self.run_without_error("plot", "many", "--observables", "time,conductors", "--out", "means.svg")
        self.assertIn("medium.viscosity", self.text("means.svg"))
        words = "ensemble scene.toml --vary medium.viscosity=0.3,0.9 --out many --quiet"
        self.run_without_error(*words.split(" "), command=runs.program)
        self.assertIn("many/ensemble-2-means-time.png",
                      self.run_without_error("plot", "many/ensemble-2.json", "--observables", "time"))
        self.check_refused("has no volume", "plot", "many", "--observables", "volume")
        self.check_refused("there is no many/absent.json", "plot", "many/absent.json")


class Chain(PicturesTest):
    SCENE = CHAIN

    def test_with_all_conductors_at_0_v_the_currents_of_the_tree_are_shown(self):
        self.assertIn("by current", self.run_without_error("plot", "scene.h5", "--out", "chain.svg"))
        words = self.text("chain.svg")
        self.assertIn("100 % connected to the ground, all at 0 V", words)
        self.assertIn("current carried to the ground (pA)", words)
        # The lowest conductor carries three currents and the uppermost one: the two ends of viridis_r.
        self.run_without_error("plot", "scene.h5")
        picture = self.picture("scene-frame-3-current.png")
        self.assertLess(pixel(picture, 0.5 + 0.03, 0.55e-3 / 8e-3)[1], 0.1)
        self.assertGreater(pixel(picture, 0.5 + 0.03, 2.65e-3 / 8e-3)[1], 0.8)
        for colour in ("strahler", "connection_time"):
            self.run_without_error("plot", "scene.h5", "--colour", colour)
        status, _, complaint = runs.command("plot", "scene.h5", "--colour", "joined", "--overwrite", folder=self.folder)
        self.assertEqual(status, 0, complaint)
        self.assertIn("--colour joined is an old name: it is called connection_time now", complaint)


class Space(PicturesTest):
    SCENE = SPACE

    def test_spheres_in_space_hide_each_other_and_cut_removes_the_front(self):
        words = ("plot", "scene.h5", "--frame", "0", "--colour", "speed")
        self.run_without_error(*words)
        self.run_without_error(*words, "--cut", "z=5")
        # The moving sphere is purple, one end of the colour map. The sphere at rest in front of it is pale.
        purple = lambda p: (p[..., 2] > p[..., 1] + 0.08)[:, :1000].sum()
        self.assertGreater(purple(self.picture("scene-frame-0-speed-cut-z-5.png")), 3000)
        self.assertEqual(purple(self.picture("scene-frame-0-speed.png")), 0)
        self.check_refused("--cut z=11 leaves nothing: the box reaches from z = 0 to 10 m", "plot", "scene.h5", "--cut", "z=11")
        self.check_refused("it must be an axis and a position on it", "plot", "scene.h5", "--cut", "w=1")


class PeriodicPacking(PicturesTest):
    SCENE = """
title = "Periodic packing"
[domain]
size = [4e-3, 4e-3]
left = "periodic"
right = "periodic"
bottom = "periodic"
top = "periodic"
[[population]]
count = 24
radius = 0.45e-3
overlapping = true
[effects.soft_repulsion]
stiffness = 1e-6
[output]
picture = false
"""

    def test_forces_across_a_side_are_short_lines_from_both_particles(self):
        with load(self.folder / "scene.h5") as result:
            shown = packing.DrawnPacking(result.file, None)
        lines, contact = shown.lines_with_images()
        self.assertGreater(len(lines), len(shown.contacts))
        self.assertLess(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).max(), 0.9)  # mm, both radii
        for end, particle in ((0, 0), (1, 1)):  # both particles of each contact are at an end of one of its lines
            at = np.isclose(lines[:, end], shown.position[shown.contacts[contact, particle]]).all(axis=1)
            self.assertEqual(set(contact[at]), set(range(len(shown.contacts))))
        disk, _ = drawing.with_images(shown.position, shown.radius, shown.period)
        self.assertGreater(len(disk), 24)


class Gas(unittest.TestCase):
    @runs.long
    def test_charge_and_cluster_give_different_pictures(self):
        for colour in ("charge", "cluster"):
            status, _, complaint = runs.command("plot", runs.gas(), "--colour", colour, "--out", f"{colour}.png")
            self.assertEqual(status, 0, complaint)
        self.assertNotEqual(*((runs.FOLDER / f"{colour}.png").read_bytes() for colour in ("charge", "cluster")))
        status, _, complaint = runs.command("plot", runs.gas(), "--colour", "size")
        self.assertEqual(status, 2)
        self.assertIn("has no size to colour by: it has charge, cluster", complaint)


if __name__ == "__main__":
    unittest.main()
