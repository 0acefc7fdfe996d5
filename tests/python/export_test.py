"""Tests that other programs' own readers, if installed, open the files of `export` (cmake/debian-test-packages.txt)."""
import csv
import importlib.util
import os
import re
import shutil
import subprocess
import tempfile
import unittest
import unittest.mock
import xml.etree.ElementTree
from pathlib import Path

import numpy as np

import runs
from lichtenberg import Failure, load
from lichtenberg.export import replace_folder
from lichtenberg.files import write_whole
from lichtenberg.result import chosen_frames


def needs(module):
    return unittest.skipUnless(importlib.util.find_spec(module), f"{module} is not installed")


def exported(result, to, *options):
    out = runs.FOLDER / f"{os.path.basename(result)}-{to}{len(options)}"
    status, answer, complaint = runs.command("export", result, "--to", to, "--out", out, "--overwrite", *options)
    assert status == 0, complaint
    assert answer.strip() == str(out)
    return out


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class ExtendedXyzTest(unittest.TestCase):
    @needs("ase")
    def test_ase_reads_every_column(self):
        import ase.io

        for path in (runs.seedling(), runs.gas(), runs.periodic(), runs.packing()):
            frames = ase.io.read(exported(path, "xyz"), index=":", format="extxyz")
            with load(path) as result:
                self.assertEqual(len(frames), len(result))
                for frame, atoms in zip(result, frames):
                    # Ten digits are written.
                    near = {"rtol": 1e-9, "atol": 1e-300}
                    np.testing.assert_allclose(atoms.positions, frame["position"], **near)
                    if "charge" in result.columns:
                        np.testing.assert_allclose(atoms.get_initial_charges(), frame["charge"], **near)
                    np.testing.assert_allclose(atoms.arrays["radius"], frame["radius"], **near)
                    if "velocity" in result.columns:
                        np.testing.assert_allclose(atoms.arrays["velo"], frame["velocity"], **near)
                    self.assertTrue((0 <= atoms.arrays["color"]).all() and (atoms.arrays["color"] <= 1).all())
                    self.assertAlmostEqual(atoms.info["Time"], frame.time, places=9)
                    self.assertEqual(atoms.info["length_unit"], result.size.unit)
                    np.testing.assert_allclose(atoms.cell.lengths()[: result.dimension], result.size, rtol=1e-9)
                    self.assertEqual(atoms.pbc.tolist(), result.periodic)

    def test_columns_have_the_names_and_kinds_of_ovitos_manual(self):
        manual = {"species": "S:1", "pos": "R:3", "velo": "R:3", "force": "R:3", "color": "R:3", "radius": "R:1"}
        manual |= {"mass": "R:1", "charge": "R:1", "cluster": "I:1", "map_shift": "I:3", "dipoles": "R:3"}
        # Names that OVITO reserves and our columns must not use; our other names are user properties.
        ours = {"position", "velocity", "image", "dipole", "type", "id", "orientation", "selection"}
        for path, known in ((runs.seedling(), 7), (runs.gas(), 8), (runs.periodic(), 9), (runs.packing(), 5)):
            head = exported(path, "xyz").read_text().splitlines()[1]
            words = next(word for word in head.split() if word.startswith("Properties=")).removeprefix("Properties=").split(":")
            columns = {name: f"{kind}:{count}" for name, kind, count in zip(words[::3], words[1::3], words[2::3])}
            self.assertFalse(ours & columns.keys())
            met = manual.keys() & columns.keys()
            self.assertGreaterEqual(len(met), known, columns)
            self.assertEqual({name: columns[name] for name in met}, {name: manual[name] for name in met})

    def test_one_scale_of_colours_in_the_whole_run(self):
        """White is zero. Only the largest value of all frames has the full colour, in its own frame."""
        with load(runs.gas()) as result:
            from lichtenberg.formats.xyz import colours

            charge = np.asarray(result["charge"])
            shown = np.array([colours(each) for each in result])
            depth = 1 - shown.min(axis=2)
            reach = result.colour_range("charge")[1]
            full = np.abs(charge) >= reach
            self.assertTrue(full.any())
            for sign in (charge > 0, charge < 0):  # A larger charge has a deeper colour, up to the scale's end.
                order = np.argsort(np.abs(charge[sign]))
                self.assertTrue((np.diff(depth[sign][order]) >= 0).all())
            self.assertTrue((depth[full & (charge > 0)] == 1 - 0.09).all() or (depth[full & (charge < 0)] == 1 - 0.13).all())
            np.testing.assert_array_equal(shown[charge == 0], 1)


class VtkTest(unittest.TestCase):
    @needs("vtk")
    def test_vtk_reads_particles_with_their_columns(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        for path in (runs.seedling(), runs.gas(), runs.periodic(), runs.packing()):
            folder = exported(path, "vtk")
            with load(path) as result:
                for frame in result:
                    reader = vtk.vtkXMLPolyDataReader()
                    reader.SetFileName(str(folder / f"particles-{frame.index:06}.vtp"))
                    reader.Update()
                    data = reader.GetOutput()
                    self.assertEqual(data.GetNumberOfVerts(), result.count)
                    np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), frame["position"])
                    for name in set(result.columns) - {"position"}:
                        np.testing.assert_array_equal(vtk_to_numpy(data.GetPointData().GetArray(name)), frame[name])
                    if "velocity" in result.columns:
                        self.assertEqual(data.GetPointData().GetVectors().GetName(), "velocity")
                    self.assertEqual(data.GetFieldData().GetArray("TimeValue").GetValue(0), frame.time)

    @needs("vtk")
    def test_lines_are_contacts_between_particles(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        folder = exported(runs.gas(), "vtk")
        with load(runs.gas()) as result:
            reader = vtk.vtkXMLPolyDataReader()
            reader.SetFileName(str(folder / "contacts-000004.vtp"))
            reader.Update()
            lines = vtk_to_numpy(reader.GetOutput().GetLines().GetConnectivityArray()).reshape(-1, 2)
            np.testing.assert_array_equal(lines, result.frame(4).contacts)

    @needs("vtk")
    def test_contacts_with_walls_are_no_lines(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        folder = exported(runs.packing(), "vtk")
        with load(runs.packing()) as result:
            frame = result.frame()
            inside = (frame.contacts < result.count).all(axis=1)
            self.assertTrue(inside.any() and not inside.all())
            reader = vtk.vtkXMLPolyDataReader()
            reader.SetFileName(str(folder / f"contacts-{frame.index:06}.vtp"))
            reader.Update()
            lines = vtk_to_numpy(reader.GetOutput().GetLines().GetConnectivityArray()).reshape(-1, 2)
            np.testing.assert_array_equal(lines, frame.contacts[inside])

    @needs("vtk")
    def test_the_field_fills_the_domain(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        reader = vtk.vtkXMLImageDataReader()
        reader.SetFileName(str(exported(runs.seedling(), "vtk") / "field.vti"))
        reader.Update()
        grid = reader.GetOutput()
        np.testing.assert_allclose(grid.GetBounds(), [0, 0.017, 0, 0.017, 0, 0], rtol=1e-14)  # Rounding.
        with load(runs.seedling()) as result:
            potential = vtk_to_numpy(grid.GetCellData().GetScalars())
            np.testing.assert_array_equal(potential.reshape(128, 128), result.field)

    @needs("vtk")
    def test_the_result_s_own_field_fills_the_domain_in_one_plane(self):
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        copy = runs.FOLDER / "copy.hdf"  # ParaView recognizes this suffix.
        shutil.copy(runs.seedling(), copy)
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(copy))
        reader.Update()
        grid = reader.GetOutput()
        np.testing.assert_allclose(grid.GetBounds(), [0, 0.017, 0, 0.017, 0, 0], rtol=1e-14)  # Rounding.
        with load(runs.seedling()) as result:
            self.assertEqual(grid.GetNumberOfCells(), result.field.size)
            values = vtk_to_numpy(grid.GetCellData().GetArray("potential"))
            np.testing.assert_array_equal(values.reshape(result.field.shape), result.field)
            ends = grid.GetCell(128 + 1).GetBounds()  # The second cell of the second row.
            np.testing.assert_allclose(ends[:4], np.array([1, 2, 1, 2]) * result.field_cell, rtol=1e-14)

    def test_the_collection_lists_the_chosen_frames_by_time(self):
        tree = xml.etree.ElementTree.parse(exported(runs.seedling(), "vtk", "--frames", "1::2") / "particles.pvd")
        listed = [(float(data.get("timestep")), data.get("file")) for data in tree.iter("DataSet")]
        with load(runs.seedling()) as result:
            self.assertEqual(listed, [(result.time[k], f"particles-{k:06}.vtp") for k in (1, 3)])


class CsvTest(unittest.TestCase):
    def test_every_column_and_observable(self):
        folder = exported(runs.seedling(), "csv")
        with load(runs.seedling()) as result:
            particles = rows_of(folder / "particles.csv")
            self.assertEqual([(int(row["frame"]), int(row["particle"])) for row in particles], [(k, i) for k in range(4) for i in range(36)])
            self.assertEqual([float(row["position y (m)"]) for row in particles], result["position"][:, :, 1].ravel().tolist())
            self.assertEqual([float(row["radius (m)"]) for row in particles[:36]], result["radius"].tolist())
            observables = rows_of(folder / "observables.csv")
            self.assertEqual([float(row["energy (J)"]) for row in observables], result.observables["energy"].tolist())
            self.assertIn('charge_drained_by_terminal the electrode "ground" (C)', observables[0])
            contacts = [(int(row["particle"]), int(row["other"])) for row in rows_of(folder / "contacts.csv") if row["frame"] == "3"]
            self.assertEqual(contacts, [tuple(pair) for pair in result.frame(3).contacts])
            self.assertIn("summary.csv", os.listdir(folder))

    def test_a_box_without_electrodes_has_no_column_of_what_they_drained(self):
        text = (runs.HOME / "scenes/pair-3d.toml").read_text().replace("time = 3.0", "time = 0.05")
        folder = exported(runs.made("insulated", text.replace("[output]", "[output]\npicture = false")), "csv")
        row = rows_of(folder / "observables.csv")[1]
        self.assertEqual(float(row["time (s)"]), 0.05)
        self.assertFalse([name for name in row if name.startswith("charge_drained_by")])

    def test_frames_are_chosen_with_their_last(self):
        with load(runs.seedling()) as result:
            for written, frames in [("2", [2]), ("0:2", [0, 1, 2]), ("::3", [0, 3]), ("3,0:1", [0, 1, 3]), ("1:3:2,1", [1, 3])]:
                self.assertEqual(chosen_frames(result, written), frames)

    def test_every_table_of_a_gas(self):
        folder = exported(runs.gas(), "csv")
        with load(runs.gas()) as result:
            gas = rows_of(folder / "gas.csv")
            self.assertEqual([float(row["temperature (m0 v0^2)"]) for row in gas], result.tables["gas"]["temperature"].tolist())

    def test_a_number_that_is_not_defined_is_an_empty_cell(self):
        """A dilute gas has no dense cell, hence no mean size of clusters of dense cells."""
        dilute = runs.made("dilute", runs.gas_scene(count=4, size=30))
        with load(dilute) as result:
            self.assertTrue(np.isnan(result.summary["density_cluster_size"]))
        folder = exported(dilute, "csv")
        value = {row["name"].split(" ")[0]: row["value"] for row in rows_of(folder / "summary.csv")}
        self.assertEqual(value["density_cluster_size"], "")
        self.assertGreater(float(value["time"]), 0)
        for name in os.listdir(folder):
            self.assertNotIn("nan", (folder / name).read_text().replace("name", ""))

    def test_what_analyse_stored_has_a_column_a_number(self):
        status, _, complaint = runs.program("analyse", runs.gas())
        self.assertEqual(status, 0, complaint)
        row = rows_of(exported(runs.gas(), "csv", "--frames", "0") / "analysis.csv")[0]
        self.assertIn("speed_density 49", row)

    def test_an_ensemble_has_a_row_a_member_and_a_point(self):
        scene = (runs.FOLDER / "gas.toml").name
        runs.gas()
        status, _, complaint = runs.program("ensemble", scene, "--seeds", 2, "--out", "both", "--quiet")
        self.assertEqual(status, 0, complaint)
        folder = exported(runs.FOLDER / "both", "csv")
        self.assertEqual(len(rows_of(folder / "members.csv")), 2)
        shutil.copy(runs.FOLDER / "both/ensemble.json", runs.FOLDER / "both/ensemble-2.json")
        self.assertEqual(rows_of(exported(runs.FOLDER / "both", "csv") / "points-2.csv"), rows_of(folder / "points.csv"))
        points = rows_of(folder / "points.csv")
        self.assertEqual(points[0]["runs"], "2")
        self.assertTrue(any(re.fullmatch(r"quantities\..*\.half_width", title) for title in points[0]))


class OverwriteTest(unittest.TestCase):
    def test_nothing_of_an_earlier_export_stays(self):
        out = exported(runs.seedling(), "vtk")
        self.assertIn("particles-000003.vtp", os.listdir(out))
        status, _, complaint = runs.command("export", runs.seedling(), "--to", "vtk", "--out", out, "--overwrite", "--frames", "0")
        self.assertEqual(status, 0, complaint)
        left = os.listdir(out)
        self.assertNotIn("particles-000003.vtp", left)
        self.assertIn("particles-000000.vtp", left)
        self.assertEqual([name for name in os.listdir(runs.FOLDER) if "before" in name or "partial" in name], [])

    def test_an_export_of_a_run_of_another_kind_is_replaced(self):
        out = runs.FOLDER / "kinds"
        for source, names in (
            (runs.seedling(), {"summary.csv", "contacts.csv"}),
            (runs.packing(), {"packing.csv"}),
            (runs.gas(), {"gas.csv"}),
            (runs.seedling(), {"summary.csv"}),
        ):
            status, _, complaint = runs.command("export", source, "--to", "csv", "--out", out, "--overwrite")
            self.assertEqual(status, 0, complaint)
            fresh = exported(source, "csv", "--frames", ":")
            self.assertLessEqual(names, set(os.listdir(out)))
            self.assertEqual(sorted(os.listdir(out)), sorted(os.listdir(fresh)))
        (out / "summary-mine.csv").write_text("notes")
        status, _, complaint = runs.command("export", runs.gas(), "--to", "csv", "--out", out, "--overwrite")
        self.assertEqual(status, 2)
        self.assertIn("kinds holds summary-mine.csv", complaint)

    def test_a_folder_may_be_named_with_a_slash_at_its_end(self):
        out = runs.FOLDER / "slashed"
        for _ in range(2):
            status, _, complaint = runs.command("export", runs.seedling(), "--to", "csv", "--out", f"{out}/", "--overwrite")
            self.assertEqual(status, 0, complaint)
            self.assertTrue((out / "particles.csv").is_file())

    def test_a_folder_with_anything_else_is_left_as_it_is(self):
        out = runs.FOLDER / "mine"
        out.mkdir()
        (out / "letter.txt").write_text("dear")
        status, _, complaint = runs.command("export", runs.seedling(), "--to", "csv", "--out", out, "--overwrite")
        self.assertEqual(status, 2)
        self.assertIn("mine holds letter.txt, which this export to csv does not write", complaint)
        self.assertEqual(os.listdir(out), ["letter.txt"])

    def test_files_and_folders_that_no_export_wrote_stay(self):
        def note(folder):
            (folder / "notes.csv").write_text("mine")

        def numbered(folder):
            (folder / "particles-000099.vtp").write_text("mine")

        def inner_folder(folder):
            (folder / "dir.csv").mkdir()
            (folder / "dir.csv" / "deep.txt").write_text("mine")

        def named_as_written(folder):
            (folder / "particles.csv").mkdir()

        def link(folder):
            (folder / "particles.csv").symlink_to("elsewhere.csv")

        for to, add in (("csv", note), ("vtk", numbered), ("csv", inner_folder), ("csv", named_as_written), ("csv", link)):
            for exported_before in (False, True):
                with self.subTest(add=add.__name__, exported_before=exported_before):
                    out = runs.FOLDER / f"{add.__name__}-{exported_before}"
                    if exported_before:
                        exported(runs.seedling(), to).rename(out)
                        (out / "particles.csv").unlink(missing_ok=True)
                    else:
                        out.mkdir()
                    add(out)
                    before = sorted(path.relative_to(out) for path in out.rglob("*"))
                    status, _, complaint = runs.command("export", runs.seedling(), "--to", to, "--out", out, "--overwrite")
                    self.assertEqual(status, 2)
                    self.assertEqual(complaint.count("\n"), 1, complaint)
                    self.assertEqual(sorted(path.relative_to(out) for path in out.rglob("*")), before)

    def replaced_beside_another(self, before, moment):
        """Replaces the folder `out`, which contains the files `before` or does not exist. Another export, which writes
        the file `theirs`, replaces it just before call number `moment` of os.rename. Returns the exception and
        `out`."""
        folder = Path(tempfile.mkdtemp(dir=runs.FOLDER))
        out, partial, aside = folder / "out", folder / "partial", folder / "before"
        for made, names in ((out, before), (partial, ["mine"])):
            if names is not None:
                made.mkdir()
                [(made / name).write_text(name) for name in names]
        rename, calls = os.rename, []

        def renamed(source, target):
            if len(calls) == moment:
                shutil.rmtree(out, ignore_errors=True)
                if moment > 0 or before is None:
                    out.mkdir()
                    (out / "theirs").write_text("theirs")
            calls.append(target)
            rename(source, target)

        raised = None
        with unittest.mock.patch("lichtenberg.export.os.rename", renamed):
            try:
                replace_folder(out, partial, aside)
            except Failure as error:
                raised = str(error)
        self.assertFalse(aside.exists())
        return raised, os.listdir(out)

    def test_of_two_exports_at_once_one_is_there_and_the_other_says_so(self):
        self.assertEqual(self.replaced_beside_another(["old"], 9), (None, ["mine"]))
        # The folder vanishes before it is moved.
        self.assertEqual(self.replaced_beside_another(["old"], 0), (None, ["mine"]))
        for before, moment in ((["old"], 1), (None, 0)):
            raised, left = self.replaced_beside_another(before, moment)
            self.assertEqual(left, ["theirs"])
            self.assertIn("out was written by another export at the same time", raised)

    @runs.long
    def test_processes_that_replace_one_folder_leave_it_whole(self):
        out = exported(runs.seedling(), "csv").rename(runs.FOLDER / "contended")
        names = sorted(os.listdir(out))
        words = [runs.PROGRAM, "export", runs.seedling(), "--to", "csv", "--out", out, "--overwrite"]
        for _ in range(3):
            exports = [subprocess.Popen(words, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) for _ in range(4)]
            for export in exports:
                _, complaint = export.communicate()
                self.assertIn(export.returncode, (0, 1), complaint)
                self.assertNotIn("Traceback", complaint)
            self.assertEqual(sorted(os.listdir(out)), names)
        self.assertEqual([path.name for path in runs.FOLDER.glob("contended.*")], [])

    def test_frames_without_contacts_leave_the_table_of_contacts_empty(self):
        out = exported(runs.packing(), "csv", "--frames", "0")
        self.assertEqual(rows_of(out / "contacts.csv"), [])
        self.assertEqual((out / "contacts.csv").read_text(), "frame,particle,other\n")


def by_the_readme(path):
    """Universe that the lines of the README make of a result."""
    readme = (runs.HOME / "src/record/README.md").read_text()
    lines = re.search(r"```python\n(import MDAnalysis.*?)```", readme, re.DOTALL).group(1)
    with load(path) as result:
        names = {"n": result.count}
    exec(lines.replace("dendrite.h5", path), names)
    return names["universe"]


class H5mdTest(unittest.TestCase):
    @needs("MDAnalysis")
    def test_mdanalysis_reads_every_kind_of_result_by_the_readme(self):
        boxes = {runs.seedling(): None, runs.packing(): None, runs.gas(): [6, 6, 6], runs.periodic(): [0.02, 0.016, 0.01]}
        for path, box in boxes.items():
            trajectory = by_the_readme(path).trajectory
            with load(path) as result:
                self.assertEqual(len(trajectory), len(result))
                for step, frame in zip(trajectory, result):
                    # MDAnalysis uses single precision.
                    np.testing.assert_array_equal(step.positions, np.float32(frame["position"]))
                    self.assertEqual(step.time, frame.time)
                    if box is None:
                        self.assertIsNone(step.dimensions)
                    else:
                        np.testing.assert_array_equal(step.dimensions, np.float32([*box, 90, 90, 90]))
                    if step.has_velocities:
                        np.testing.assert_array_equal(step.velocities, np.float32(frame["velocity"]))

    @needs("MDAnalysis")
    def test_mdanalysis_finds_contacts_across_sides_by_the_box(self):
        from MDAnalysis.lib.distances import calc_bonds

        trajectory = by_the_readme(runs.gas()).trajectory
        across = 0
        with load(runs.gas()) as result:
            radius = np.asarray(result["radius"])
            for step, frame in zip(trajectory, result):
                first, other = frame.contacts.T
                # Grains in contact overlap; positions are rounded to 24 bits.
                reach = (radius[first] + radius[other]) * (1 + 1e-5)
                ends = step.positions[first], step.positions[other]
                self.assertTrue((calc_bonds(*ends, box=step.dimensions) <= reach).all())
                across += (calc_bonds(*ends) > reach).sum()
        self.assertGreater(across, 0)

    def test_box_edges_are_those_of_the_domain_in_every_frame(self):
        for path in (runs.gas(), runs.periodic()):
            with load(path) as result:
                edges = result.file["particles/conductors/box/edges"]
                np.testing.assert_array_equal(edges["value"], [np.diag(result.size)] * len(result))
                self.assertEqual(edges["value"].attrs["unit"], result.size.unit)
                for clock in ("step", "time"):  # H5MD requires the same datasets.
                    self.assertEqual(edges[clock], result.file["particles/conductors/position"][clock])


class PackingTest(unittest.TestCase):
    def test_contacts_are_those_of_the_last_frame(self):
        folder = exported(runs.packing(), "csv")
        with load(runs.packing()) as result:
            last = len(result) - 1
            contacts = [(int(row["frame"]), int(row["particle"]), int(row["other"])) for row in rows_of(folder / "contacts.csv")]
            self.assertEqual(contacts, [(last, *pair) for pair in result.frame().contacts])
        written = os.listdir(exported(runs.packing(), "vtk"))
        self.assertEqual([name for name in written if name.startswith("contacts-")], [f"contacts-{last:06}.vtp"])


class RefusedTest(unittest.TestCase):
    def refused(self, words, *command, run=runs.command):
        status, answer, complaint = run(*command)
        self.assertEqual(status, 2, complaint)
        self.assertEqual(answer, "")
        self.assertEqual(complaint.count("\n"), 1, complaint)
        self.assertTrue(complaint.startswith("lichtenberg: "))
        self.assertIn(words, complaint)

    def test_one_sentence_each(self):
        result = runs.seedling()
        taken = exported(result, "xyz")
        before = taken.read_text()
        self.refused("give --overwrite", "export", result, "--to", "xyz", "--out", taken)
        self.assertEqual(taken.read_text(), before)
        self.refused("frames 0 to 3", "export", result, "--to", "csv", "--frames", "4")
        self.refused("frames 0 to 3", "export", result, "--to", "csv", "--frames", "0:9")
        self.refused("is reversed", "export", result, "--to", "csv", "--frames", "3:1")
        self.refused("`first` is not a frame", "export", result, "--to", "csv", "--frames", "first")
        self.refused("`-1` must be a whole number", "export", result, "--to", "csv", "--frames", "::-1")
        self.refused("more than FIRST:LAST:STEP", "export", result, "--to", "csv", "--frames", "0:1:1:1")
        self.refused("there is no folder", "export", result, "--to", "xyz", "--out", "nowhere/x.xyz")
        self.refused("--to", "export", result, run=runs.program)
        self.refused("vtk", "export", result, "--to", "pdb", run=runs.program)
        self.refused("nowhere.h5", "export", "nowhere.h5", "--to", "xyz", run=runs.program)
        self.refused("ensemble.json", "export", runs.FOLDER, "--to", "csv", run=runs.program)
        (runs.FOLDER / "text.h5").write_text("no HDF5")
        self.refused("text.h5", "export", "text.h5", "--to", "xyz", run=runs.program)
        self.refused("text.h5", "view", "text.h5", run=runs.program)
        self.refused("frames 0 to 3", "view", result, "--frames", "7")

    def test_what_is_read_and_other_results_and_links_are_never_replaced(self):
        result = runs.seedling()
        link = runs.FOLDER / "link"
        link.symlink_to("elsewhere")
        for out in (result, runs.gas(), link, runs.FOLDER):
            for command in (["view"], ["export", "--to", "xyz"]):
                self.refused("is not overwritten", *command, result, "--out", out, "--overwrite")
        self.refused("is not overwritten", "export", result, "--to", "csv", "--out", result, "--overwrite")
        self.assertEqual(len(load(result)), 4)

    def test_nothing_is_left_of_what_failed(self):
        with self.assertRaises(ZeroDivisionError):
            write_whole(runs.FOLDER / "failed.csv", (str(1 / n) for n in (1, 0)))
        self.assertEqual([name for name in os.listdir(runs.FOLDER) if "failed" in name], [])


if __name__ == "__main__":
    unittest.main()
