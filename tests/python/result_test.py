"""Tests that the Python package reads the program's results and calls the program."""
import json
import os
import re
import shutil
import unittest
import warnings

import h5py
import numpy as np

import runs

os.environ["LICHTENBERG"] = runs.PROGRAM
import lichtenberg
from lichtenberg import InputError, load


class ResultTest(unittest.TestCase):
    def test_arrays_are_the_file_s_with_units(self):
        with lichtenberg.load(runs.seedling()) as result, h5py.File(runs.seedling(), locking=False) as file:
            stored = file["particles/conductors/position/value"][()]
            self.assertEqual(len(result), 4)
            self.assertEqual(result.count, 36)
            np.testing.assert_array_equal(result["position"], stored)
            np.testing.assert_array_equal(result.frame(2)["position"], stored[2])
            np.testing.assert_array_equal(result[2]["position"], stored[2])
            self.assertEqual(result[-1].time, result.frame().time)
            np.testing.assert_array_equal(result.frame()["radius"], file["particles/conductors/radius"][()])
            self.assertEqual(result["position"][1, :, 0].unit, "m")
            self.assertEqual(result.time.unit, "s")
            self.assertAlmostEqual(result.frame(-1).time, 0.3, places=12)
            self.assertEqual([frame.index for frame in result], [0, 1, 2, 3])
            self.assertEqual(result.size.tolist(), [0.017, 0.017])
            self.assertEqual(result.dimension, 2)

    def test_arithmetic_has_no_unit(self):
        with lichtenberg.load(runs.seedling()) as result:
            position = result["position"]
            for derived in (position * position, np.sqrt(abs(position)), position.sum(axis=1), position + 1.0):
                self.assertIs(type(derived), np.ndarray)
            position[0] += 1.0  # In-place operations keep the unit.
            self.assertEqual(position.unit, "m")

    def test_grains_in_si(self):
        with lichtenberg.load(runs.gas()) as result:
            scales = result.scales
            self.assertEqual(scales["t0"], scales["d0"] / scales["v0"])
            velocity = result.frame()["velocity"]
            self.assertEqual(velocity.in_si(scales).unit, "m s-1")
            np.testing.assert_array_equal(velocity.in_si(scales), scales["v0"] * np.asarray(velocity))
            potential = lichtenberg.Array([2.0], "q0/d0").in_si(scales)
            self.assertEqual((potential.unit, potential[0]), ("m-1 C", 2.0 * (scales["q0"] * scales["d0"] ** -1)))
            energy = lichtenberg.Array([3.0], "m0 v0^2").in_si(scales)
            self.assertEqual(energy.unit, "m2 kg s-2")
            self.assertAlmostEqual(energy[0] / (3 * scales["m0"] * scales["v0"] ** 2), 1, places=14)
            self.assertEqual(lichtenberg.Array([1], "1").in_si(scales).unit, "1")
        with lichtenberg.load(runs.seedling()) as result:
            self.assertEqual(result.scales, {})
            self.assertEqual(result.frame()["position"].in_si(result.scales).unit, "m")

    def test_contacts_and_tree(self):
        with lichtenberg.load(runs.seedling()) as result, h5py.File(runs.seedling(), locking=False) as file:
            last = result.frame()
            np.testing.assert_array_equal(last.contacts, file["network/contacts"][()])
            joined = np.concatenate([frame.contacts for frame in result])
            np.testing.assert_array_equal(joined, file["network/contacts_of_all_frames"][()])
            successor = file["particles/conductors/successor/value"][-1]
            self.assertEqual(len(last.tree), np.count_nonzero(successor != -2))
            self.assertTrue((last.tree[:, 1] == -1).any())
            self.assertEqual(len(last.tree), int(result.observables["connected"][-1]))

    def test_a_packing_not_at_rest_is_marked_everywhere(self):
        with lichtenberg.load(runs.packing()) as result:
            self.assertEqual(result.warnings, [])
        words = "not at rest after 5 iterations"
        with lichtenberg.load(runs.unfinished_packing()) as result:
            self.assertTrue(result.warnings[0].startswith(words + ": "))
            with h5py.File(runs.unfinished_packing(), locking=False) as file:
                self.assertEqual(file["summary"].attrs["warnings"].shape, (len(result.warnings),))
        status, out, complaint = runs.program("network", runs.unfinished_packing(), "--no-save", "--json")
        self.assertEqual(status, 0)
        self.assertTrue(json.loads(out)["warnings"][0].startswith(words))
        self.assertRegex(complaint, f"^WARNING +{words}: ")
        status, _, complaint = runs.program("plot", runs.unfinished_packing(), "--out", "unfinished.svg", "--overwrite")
        self.assertEqual((status, complaint), (0, ""))
        self.assertIn(f"WARNING: {words}", (runs.FOLDER / "unfinished.svg").read_text())
        status, out, _ = runs.program("network", runs.unfinished_packing(), "--no-save", "--json", "--frame", "0")
        self.assertTrue(json.loads(out)["warnings"][0].startswith("not at rest: the frame is not the run's last"))

    def test_what_stands_beside(self):
        with lichtenberg.load(runs.seedling()) as result:
            self.assertEqual(result.observables["energy"].unit, "J")
            self.assertEqual(result.terminals["charge_drained_by_terminal"], ['the electrode "ground"'])
            self.assertEqual(result.title, "Seedling")
            self.assertIn("[effects.hertz_contact]", result.scene)
            self.assertIn("commit", result.provenance[0])
            self.assertAlmostEqual(result.summary["time"], 0.3, places=12)
            self.assertEqual(result.field.shape, (128, 128))
        with lichtenberg.load(runs.gas()) as result:
            self.assertEqual(result.dimension, 3)
            self.assertEqual(result.periodic, [True, True, True])
            self.assertEqual(result.tables["gas"]["temperature"].unit, "m0 v0^2")
            self.assertIsNone(result.field)

    def test_a_notebook_gets_the_picture(self):
        with lichtenberg.load(runs.seedling()) as result:
            picture = result.frame(1)._repr_png_()
            self.assertTrue(picture.startswith(b"\x89PNG"))
            self.assertNotEqual(picture, result._repr_png_())
            whole = result.plot(colour="charge")._repr_png_()
            self.assertNotEqual(result.plot(colour="charge", range=(-1e-12, 1e-12))._repr_png_(), whole)

    def test_what_is_not_there_is_a_sentence(self):
        with lichtenberg.load(runs.seedling()) as result:
            for ask, words in [
                (lambda: result.frame(4), "frames 0 to 3"),
                (lambda: result["colour"], "no colour of particles; it has charge"),
                (lambda: lichtenberg.load("nowhere.h5"), "nowhere.h5 does not exist"),
                (lambda: lichtenberg.load(__file__), "cannot be read as an HDF5 file"),
            ]:
                with self.assertRaisesRegex(lichtenberg.InputError, words):
                    ask()

    def test_rows_of_segments_that_are_gone_are_not_taken_for_numbers(self):
        index, other = (str(runs.FOLDER / name) for name in ("index.h5", "other.h5"))
        shutil.copy(runs.seedling(), index)
        with h5py.File(index, "r+") as file:
            file.create_group("segments")
        shutil.copy(index, other)
        with lichtenberg.load(index) as result:
            self.assertEqual(len(result["charge"]), 4)
            os.replace(other, index)
            with self.assertRaisesRegex(lichtenberg.InputError, "load it again"):
                result["charge"]


class PagesTest(unittest.TestCase):
    def run_lines(self, page):
        """Runs the Python blocks of a page and returns their names."""
        lines = "\n".join(re.findall(r"```python\n(.*?)```", (runs.HOME / page).read_text(), re.DOTALL))
        for name in ("dendrite.h5", "dendrite.html", "short.h5"):
            lines = lines.replace(name, str(runs.FOLDER / name))
        names = {}
        exec(lines.replace("scenes/", f"{runs.HOME}/scenes/"), names)
        return names

    def test_the_guide_to_solving_runs(self):
        names = self.run_lines("docs/how-to/solve-in-python.md")
        self.assertEqual(names["s"].potential.shape, (2,))
        self.assertEqual(names["frame"].charge.shape, (2,))
        self.assertEqual(load(runs.FOLDER / "short.h5")[-1]["charge"].shape, (36,))

    def test_the_readme_runs(self):
        shutil.copy(runs.seedling(), runs.FOLDER / "dendrite.h5")
        names = self.run_lines("python/README.md")
        self.assertEqual(names["last"]["position"].shape, (36, 3))
        for written in ("dendrite.html", "dendrite.xyz"):
            self.assertGreater((runs.FOLDER / written).stat().st_size, 10_000)


class SolveTest(unittest.TestCase):
    scene = {
        "domain": {"size": [16e-3, 16e-3], "bottom": {"potential": 0.0}},
        "medium": {"permittivity": 4e-11},
        "conductor": lichtenberg.conductors(np.array([[5e-3, 8e-3], [11e-3, 8e-3]]), radius=1e-3, charge=[1e-10, 0.0]),
        "effects": {"floating_conductors": {}},
        "field": {"cells": 64},
    }

    def test_arrays_go_in_and_come_out(self):
        found = lichtenberg.solve(self.scene, capacitance=True)
        self.assertEqual(found.potential.shape, (2,))
        self.assertEqual(found.force.shape[0], 2)
        # The solver's relative tolerance is 1e-10; the zero of the second conductor is relative to the first's charge.
        np.testing.assert_allclose(found.charge, [1e-10, 0], atol=1e-19)
        # With the side at 0 V, q = C phi. Both sides have the accuracy of one solver, and so does the symmetry.
        matrix = found.capacitance.matrix
        names = found.capacitance.groups
        inner = [names.index(f"conductor {k}") for k in (0, 1)]
        np.testing.assert_allclose(matrix[np.ix_(inner, inner)] @ found.potential, found.charge, atol=1e-17)
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-8 * abs(matrix).max())

    def test_a_list_repeats_an_option(self):
        settings = ["medium.depth=3.0", "field.cells=64"]
        found = lichtenberg.solve(self.scene, settings)
        expected = lichtenberg.solve({**self.scene, "medium": {**self.scene["medium"], "depth": 3.0}}, "field.cells=64")
        np.testing.assert_array_equal(found.potential, expected.potential)
        self.assertNotEqual(found.potential.tolist(), lichtenberg.solve(self.scene).potential.tolist())

    def test_a_file_is_as_good_as_a_dictionary(self):
        path = runs.FOLDER / "two.toml"
        path.write_text(
            "[domain]\nsize = [16e-3, 16e-3]\nbottom = { potential = 0.0 }\n[medium]\npermittivity = 4e-11\n"
            "[[conductor]]\nposition = [5e-3, 8e-3]\nradius = 1e-3\ncharge = 1e-10\n"
            "[[conductor]]\nposition = [11e-3, 8e-3]\nradius = 1e-3\n[effects.floating_conductors]\n[field]\ncells = 64\n"
        )
        np.testing.assert_array_equal(lichtenberg.solve(path).potential, lichtenberg.solve(self.scene).potential)

    def test_keys_of_a_scene_can_be_set(self):
        deep = lichtenberg.solve(self.scene, {"medium.depth": 4e-3, "conductor[0].charge": 2e-10})
        # Twice the charge and twice the depth (of 2 mm, the largest diameter): equal potentials and twice the energy.
        plain = lichtenberg.solve(self.scene)
        np.testing.assert_allclose(deep.potential, plain.potential, rtol=1e-7)  # Solver tolerance, 1e-8 or better.
        self.assertAlmostEqual(deep.energy / plain.energy, 2, places=6)

    def test_the_program_s_sentence_is_the_error(self):
        with self.assertRaisesRegex(lichtenberg.InputError, "unknown key fiel"):
            lichtenberg.solve({**self.scene, "fiel": {}})

    def test_run_returns_its_result(self):
        effects = {"floating_conductors": {}, "stokes_drag": {}}
        moving = {**self.scene, "effects": effects, "stop": {"time": 1e-3}, "output": {"picture": False}}
        moving["medium"] = {"permittivity": 4e-11, "viscosity": 0.7}
        with lichtenberg.run(moving, runs.FOLDER / "moving.h5") as result:
            self.assertEqual(result.count, 2)
            self.assertAlmostEqual(result.frame().time, 1e-3, places=12)


class RefusedTest(unittest.TestCase):
    def test_what_cannot_be_read_is_one_sentence(self):
        with load(runs.seedling()) as result:
            for index in (1.5, "1", None, True):
                with self.assertRaisesRegex(InputError, "is no whole number: .* has frames 0 to 3"):
                    result.frame(index)
        with self.assertRaisesRegex(InputError, "has been closed"):
            result.frame(0)["position"]
        with self.assertRaisesRegex(InputError, "is no path"):
            load(3)
        with self.assertRaisesRegex(InputError, "positions of conductors are"):
            lichtenberg.conductors([1, 2])
        with self.assertRaisesRegex(InputError, "radius has the shape"):
            lichtenberg.conductors([[1, 2], [3, 4]], radius=[1, 2, 3])

    def test_a_file_without_a_scene_is_incomplete_to_all(self):
        path = runs.FOLDER / "bare.h5"
        shutil.copy(runs.seedling(), path)
        with h5py.File(path, "a") as file:
            del file["scene"]
        with self.assertRaisesRegex(InputError, "/scene is missing"):
            load(path)
        for command in (["plot"], ["plot", "--series"], ["view"], ["export", "--to", "csv"], ["film"], ["analyse"], ["network"]):
            status, _, complaint = runs.program(*command, path)
            self.assertEqual(status, 2, complaint)
            self.assertRegex(complaint, "scene.* is missing", command)
            self.assertNotRegex(complaint, "Error|component|Traceback")

    def test_a_damaged_part_raises_input_error_where_it_is_read(self):
        path = runs.FOLDER / "holes.h5"
        shutil.copy(runs.gas(), path)
        with h5py.File(path, "a") as file:
            del file["scene"].attrs["title"], file["provenance"], file["particles/conductors/charge/value"]
            del file["scene/text"], file["observables"]
            file["scene/text"], file["observables"] = np.arange(3.0), np.arange(3.0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = load(path)
        reads = [lambda: result.title, lambda: result.provenance, lambda: result["charge"], lambda: result[0]["charge"],
                 lambda: result.observables, lambda: result.terminals]  # fmt: skip
        for k, read in enumerate(reads):
            with self.subTest(k), self.assertRaisesRegex(InputError, r"holes.h5 is damaged or incomplete \((?!\w+Error:)"):
                read()


if __name__ == "__main__":
    unittest.main()
