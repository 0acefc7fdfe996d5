"""The module in the interpreter's process: scenes, solves, runs, forces from Python, and bad input."""
import gc
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import textwrap
import threading
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "python"))
import numpy as np

import lichtenberg as li
import runs
from lichtenberg import core

if core.find() is None:
    print("module_test: the module is not built (pybind11-dev is missing): skipped")
    sys.exit(77)

TWO_DISKS, TWO_GRAINS, PAIR_3D, SEEDLING = (
    str(SOURCE / f"scenes/{name}.toml") for name in ("two-disks", "two-grains", "pair-3d", "seedling"))
FALL = {  # one disk without forces of its own
    "domain": {"size": [1e-2, 1e-2]},
    "medium": {"permittivity": 1.0, "viscosity": 1e-3},
    "material": {"density": 1000.0},
    "effects": {"stokes_drag": {}},
    "conductor": [{"position": [5e-3, 5e-3], "radius": 1e-3}],
    "stop": {"time": 0.2, "stationary": False},
    "output": {"every": 0.05, "picture": False},
}
COLLISION = {  # two grains that collide head-on
    "units": {},
    "domain": {"size": [12, 12, 12],
               **{side: "periodic" for side in ("left", "right", "bottom", "top", "front", "back")}},
    "conductor": [{"position": [5.4, 6, 6], "velocity": [1, 0, 0], "radius": 0.5},
                  {"position": [6.6, 6, 6], "velocity": [-1, 0, 0], "radius": 0.5, "charge": 0.25}],
    "effects": {"viscoelastic_contact": {}, "charge_exchange": {"model": "none"}},
    "stop": {"time": 1},
}


def run_command(scene_text, folder):
    scene = Path(folder) / "scene.toml"
    scene.write_text(scene_text)
    program = os.environ.get("LICHTENBERG", str(SOURCE / "build/lichtenberg"))
    out = str(Path(folder) / "command.h5")
    subprocess.run([program, "run", str(scene), "--out", out, "--quiet"], check=True)
    return li.load(out)

class Scenes(unittest.TestCase):
    def test_path_dictionary_and_tables_give_the_same_scene(self):
        tables = {"domain": {"size": [8e-3, 8e-3], "bottom": {"potential": 0.0}}, "effects": {"floating_conductors": {}},
                  "conductor": [{"position": [4e-3, 4e-3], "radius": 1e-3, "charge": 1e-12}],
                  "medium": {"permittivity": 2.0}}
        from_dictionary, from_tables = li.Scene(tables), li.Scene(**tables)
        self.assertEqual(len(from_dictionary), 1)
        self.assertEqual(sorted(from_dictionary.text.splitlines()), sorted(from_tables.text.splitlines()))

    def test_settings_replace_keys(self):
        self.assertIn("cells = 96", li.Scene(TWO_DISKS, {"field.cells": 96}).text)
        self.assertIn("cells = 96", li.Scene(TWO_DISKS, "field.cells=96").text)

    def test_errors_name_file_line_and_key(self):
        with self.assertRaises(li.InputError) as caught:
            li.Scene({**FALL, "medium": {"permittivity": -1.0}})
        self.assertEqual(caught.exception.key, "medium.permittivity")
        self.assertEqual(caught.exception.file, "scene")
        with self.assertRaises(li.InputError) as caught:
            li.Scene(TWO_DISKS, {"field.cells": -1})
        self.assertEqual((caught.exception.file, caught.exception.key), (TWO_DISKS, "field.cells"))
        with self.assertRaises(li.InputError) as caught:
            li.Scene("missing.toml")
        self.assertEqual((caught.exception.file, caught.exception.key), ("missing.toml", None))

    def test_an_integrator_of_another_program_is_refused_with_the_reason(self):
        with self.assertRaisesRegex(li.InputError, "must be one of .*; integrators that a C\\+\\+ program adds are unknown") as caught:
            li.Scene(TWO_DISKS, {"mechanics.integrator": "heun"})
        self.assertEqual(caught.exception.key, "mechanics.integrator")

    def test_bad_sources_are_refused(self):
        def refused(words, *arguments, **named):
            with self.assertRaisesRegex(li.InputError, words):
                li.Scene(*arguments, **named)
        for source in (3, [1], b"x", object()):
            refused("is no scene: give a path or a dictionary", source)
        refused("needs a path, a dictionary, or keyword tables")
        refused("no keyword tables, as domain", FALL, domain={"size": [1, 1]})
        refused("there is no such scene file", "missing.toml")
        refused("the scene file cannot be read", "/")
        refused("must be KEY=VALUE", TWO_DISKS, "no setting")
        refused("are no settings", TWO_DISKS, 3)
        refused("is set twice", TWO_DISKS, ["field.cells=64", "field.cells=65"])
        refused("a scene cannot hold object", {**FALL, "seed": object()})
        refused("is no key of a scene: keys are texts", {**FALL, 3: 4})
        refused("too large for a scene", {**FALL, "seed": 2**70})
        refused("is no valid Unicode", {**FALL, "title": "\ud800"})
        refused("is no list of effects", FALL, compiled=["stokes_drag"])
        refused("conductor.position", {**FALL, "conductor": li.conductors(np.full((1, 2), np.nan), radius=1e-3)})
        with self.assertRaisesRegex(li.InputError, "these have the shape"):
            li.conductors(np.zeros(3), radius=1e-3)

    def test_a_scene_is_a_value(self):
        tables = {**FALL, "stop": dict(FALL["stop"])}
        scene = li.Scene(tables)
        tables["stop"]["time"] = 9.0
        self.assertEqual(scene.changed({"output.every": 0.1}).text.count("9.0"), 0)
        again = pickle.loads(pickle.dumps(scene))
        self.assertEqual(again.text, scene.text)
        self.assertEqual(pickle.loads(pickle.dumps(li.solve(TWO_DISKS).charge)).unit, "C")

    def test_former_names_warn(self):
        scene = {**FALL, "field": {"links": "log-fitted"}, "effects": {"floating_conductors": {}}}
        with self.assertWarnsRegex(UserWarning, "boundary_stencil"):
            li.Scene(scene)


class Solves(unittest.TestCase):
    def test_solution_is_that_of_the_command(self):
        import json
        program = os.environ.get("LICHTENBERG", str(SOURCE / "build/lichtenberg"))
        words = [program, "solve", TWO_DISKS, "--json", "--capacitance"]
        expected = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)
        found = li.solve(TWO_DISKS, capacitance=True)
        for name in ("potential", "charge", "radius", "group", "position", "force"):
            self.assertEqual(getattr(found, name).tolist(), [row[name] for row in expected["conductors"]], name)
        for name in ("electrodes", "energy", "depth", "method", "unknowns", "iterations", "residual", "warnings"):
            self.assertEqual(getattr(found, name), expected[name], name)
        self.assertEqual(found.capacitance.matrix.tolist(), expected["capacitance"]["matrix"])
        self.assertEqual(found.charge.unit, "C")
        self.assertEqual(found.units, expected["units"])
        self.assertEqual(set(vars(found)), set(expected) - {"conductors"} | {
            "position", "radius", "group", "potential", "charge", "force"})

    def test_potential_field(self):
        found = li.solve(TWO_DISKS, {"field.cells": 64}, potential_field=True)
        self.assertEqual(found.potential_field.unit, "V")
        self.assertEqual(max(found.potential_field.shape), 64)
        self.assertTrue(np.isfinite(found.potential_field).all())

    def test_grains_have_their_units(self):
        found = li.solve(TWO_GRAINS)
        self.assertEqual(found.force.shape, (2, 3))
        self.assertEqual(found.force.unit, "m0 v0^2/d0")
        self.assertEqual(li.solve(PAIR_3D).force.shape, (2, 3))

    def test_scenes_without_a_field_are_refused(self):
        for words, arguments in (("has no table \\[effects.floating_conductors\\]", [FALL, {}]), ("it must be \"cpu\" or \"cuda\"", [TWO_DISKS, {"device": "tpu"}]),
                                 ("solved on the CPU", [TWO_GRAINS, {"device": "cuda"}]),
                                 ("leave them out for charged grains", [TWO_GRAINS, {"capacitance": True}]),
                                 ("is not on a grid", [PAIR_3D, {"potential_field": True}])):
            with self.assertRaisesRegex(li.InputError, words):
                li.solve(arguments[0], **arguments[1])

    def test_threads_solve_at_once(self):
        alone = li.solve(TWO_DISKS).potential.tolist()
        found = []
        threads = [threading.Thread(target=lambda: found.append(li.solve(TWO_DISKS).potential.tolist())) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, [alone] * 4)

    def test_a_forked_process_solves(self):
        alone = li.solve(TWO_DISKS).potential.tolist()
        child = os.fork()
        if child == 0:
            try:
                os._exit(0 if li.solve(TWO_DISKS).potential.tolist() == alone else 3)
            except BaseException:
                os._exit(4)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)

    def test_many_solves_keep_the_memory(self):
        def resident():
            return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        random = np.random.default_rng(5)
        def solve_one():
            position = random.uniform(2e-3, 6e-3, 2)
            li.solve({"domain": {"size": [8e-3, 8e-3]}, "medium": {"permittivity": 2.0}, "field": {"cells": 64},
                      "effects": {"floating_conductors": {}},
                      "conductor": [{"position": position, "radius": random.uniform(2e-4, 1e-3), "charge": 1e-12}],
                      "electrode": [{"shape": "disk", "centre": [7e-3, 1e-3], "radius": 5e-4, "potential": 1.0}]})
        for _ in range(30):
            solve_one()
        before = resident()
        for _ in range(100):
            solve_one()
        self.assertLess(resident() - before, 2e6)  # a leak of one grid (64 x 64 doubles) per solve is 3.3e6


class Runs(unittest.TestCase):
    def test_frames_and_file_are_those_of_the_command(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = li.Scene(SEEDLING, {"stop.time": 0.1, "output.picture": False})
            expected = run_command(scene.text, folder)
            for record in (True, False):
                run = li.Run(scene, record=record)
                positions, times = [], []
                for frame in run.frames():
                    positions.append(frame.position.copy())
                    times.append(frame.time)
                self.assertTrue(run.finished)
                self.assertEqual(times, expected.time.tolist())
                self.assertTrue((np.array(positions) == np.asarray(expected["position"])).all())
                if record:
                    path = run.save(f"{folder}/module.h5")
                    found = li.load(path)
                    for name in expected.columns:
                        self.assertTrue((np.asarray(found[name]) == np.asarray(expected[name])).all(), name)
                    self.assertEqual(found.summary, expected.summary)
                self.assertEqual({name: value for name, (value, _) in run.summary.items()}, expected.summary)

    def test_a_constant_force_drives_against_the_drag(self):
        run = li.Run(FALL, record=False)
        force = 1e-9
        run.add_force(lambda state: np.tile([force, 0.0], (len(state.mass), 1)))
        frames = list(run.frames(every=0.05))
        self.assertEqual(len(frames), 5)
        drag = 6 * np.pi * 1e-3 * 1e-3
        rate = drag / (4 / 3 * np.pi * 1e-9 * 1000.0)
        t = frames[-1].time
        moved = force / drag * (t - (1 - np.exp(-rate * t)) / rate)
        # The position error of a step is at most position_tolerance, 1e-3 of the radius by default. The errors of the
        # steps have one sign and decay with the velocity within a few steps.
        self.assertLess(abs(frames[-1].position[0, 0] - 5e-3 - moved), 5 * 1e-3 * 1e-3)
        self.assertEqual(frames[-1].position[0, 1], 5e-3)

    def test_faulty_forces_end_the_run(self):
        def throws(state):
            raise ZeroDivisionError("my own")

        cases = [(throws, ZeroDivisionError), (lambda state: np.full((1, 2), np.nan), li.InputError),
                 (lambda state: np.zeros(2), li.InputError), (lambda state: "text", li.InputError),
                 (lambda state: None, li.InputError), (lambda state: (np.zeros((1, 2)), np.inf), li.InputError)]
        for function, kind in cases:
            run = li.Run(FALL, record=False)
            run.add_force(function)
            with self.assertRaises(kind):
                list(run.frames())
            with self.assertRaises(li.Failure):
                list(run.frames())
        with self.assertRaises(li.InputError):
            li.Run(FALL).add_force(3)

    def test_a_force_may_keep_the_arrays_of_the_state(self):
        kept = []
        run = li.Run(FALL, record=False)

        @run.add_force
        def force(state):
            kept.append((state.time, state.position))
            state.position[0, 0] = 0  # changes a copy
            return np.zeros((1, 2))
        positions = [frame.position.tolist() for frame in run.frames()]
        self.assertEqual(positions[-1], [[5e-3, 5e-3, 0]])
        self.assertTrue(all(position.tolist() == [[0, 5e-3]] for _, position in kept))

    def test_energy_of_a_force_enters_the_balance(self):
        def spring(state):
            away = state.position - np.array([0.0775, 0.0775])
            return -1e-6 * away, 0.5e-6 * (away**2).sum()
        run = li.Run(str(SOURCE / "scenes/pair.toml"), {"stop.time": 0.1}, record=False)
        run.add_force(spring)
        run.finish()
        self.assertEqual([text for text in run.warnings if "energy" in text], [])
        run = li.Run(str(SOURCE / "scenes/pair.toml"), {"stop.time": 0.1}, record=False)
        for wrong in (lambda state: (np.zeros((2, 2)), "much"), lambda state: (np.zeros((2, 2)), None)):
            run = li.Run(str(SOURCE / "scenes/pair.toml"), record=False)
            run.add_force(wrong)
            with self.assertRaisesRegex(li.InputError, "an energy that is no finite number"):
                run.finish()

    def test_charge_exchange_of_a_function_is_applied_exactly(self):
        seen = []
        run = li.Run(COLLISION, record=False)

        @run.add_charge_exchange
        def by_speed(contacts):
            seen.append(contacts)
            return 0.01 * contacts.impact_speed * contacts.direction[:, 0]
        frames = list(run.frames())
        self.assertEqual(len(seen), 1)
        self.assertEqual(seen[0].pair.tolist(), [[0, 1]])
        self.assertEqual(seen[0].charge.tolist(), [[0, 0.25]])
        self.assertEqual(seen[0].radius.tolist(), [[0.5, 0.5]])
        self.assertAlmostEqual(seen[0].impact_speed[0], 2, 12)
        self.assertEqual(seen[0].direction.tolist(), [[-1, 0, 0]])
        charge = frames[-1].charge
        self.assertAlmostEqual(float(charge[0]), -0.02, 11)
        self.assertEqual(float(charge[0] + charge[1]), 0.25)

    def test_faulty_charge_exchange_is_refused(self):
        with self.assertRaisesRegex(li.InputError, "is none"):
            li.Run(FALL).add_charge_exchange(3)
        run = li.Run(FALL, record=False)
        run.add_charge_exchange(lambda contacts: 0)
        with self.assertRaisesRegex(li.InputError, "only grains exchange charge"):
            run.finish()
        for function, text in ((lambda contacts: "text", "an array of charges"), (lambda contacts: [0] * 10**4, "charges, one"),
                               (lambda contacts: np.full(len(contacts.pair), np.nan), "not finite")):
            run = li.Run(COLLISION, record=False)
            run.add_charge_exchange(function)
            with self.assertRaisesRegex(li.InputError, text):
                run.finish()
        run = li.Run(COLLISION, record=False)
        run.add_charge_exchange(lambda contacts: np.zeros(len(contacts.pair)), unit=0)
        with self.assertRaisesRegex(li.InputError, "must be positive"):
            run.finish()

    def test_coagulation_with_a_constant_kernel_is_the_closed_form(self):
        found = li.coagulate(lambda i, j: 1.0, [1, 20, 200], tolerance=1e-3)
        self.assertLessEqual(found.error, 1e-3)
        for t, size, number, width in zip(found.time, found.size, found.number, found.width):
            self.assertLess(abs(size / (1 + t) - 1), 1e-3)
            self.assertLess(abs(number * (2 + t) / 2 - 1), 1e-6)
            self.assertAlmostEqual(width**2, size * number - 1, 9)
        for kernel, times in ((lambda i, j: -1.0, [1]), (lambda i, j: 1.0, [2, 1]), (lambda i, j: 1.0, []), (1, [1])):
            with self.assertRaises(li.InputError):
                li.coagulate(kernel, times)
        with self.assertRaises(ZeroDivisionError):
            li.coagulate(lambda i, j: 1 / 0, [1])

    def test_forces_on_a_packing_are_refused(self):
        run = li.Run(str(SOURCE / "scenes/packing.toml"), record=False)
        run.add_force(lambda state: np.zeros_like(state.position))
        with self.assertRaisesRegex(li.InputError, "effects.soft_repulsion has no other forces"):
            run.finish()

    def test_a_frame_has_arrays_until_the_run_continues(self):
        frames = li.Run(FALL, record=False).frames()
        first = next(frames)
        start = first.position.tolist()
        second = next(frames)
        third = next(frames)
        self.assertEqual(first.position.tolist(), start)
        with self.assertRaisesRegex(li.InputError, "the run has left the frame at t = 0.05 s"):
            second["position"]
        with self.assertRaisesRegex(AttributeError, "the run has left the frame"):
            second.position
        with self.assertRaises(AttributeError):
            third.nothing
        self.assertFalse(hasattr(second, "position"))
        self.assertEqual(pickle.loads(pickle.dumps(first)).position.tolist(), start)
        self.assertIn("position", third)

    def test_scenes_are_never_overwritten(self):
        with tempfile.TemporaryDirectory() as folder:
            scene, other = Path(folder) / "a.toml", Path(folder) / "other.toml"
            for path in (scene, other):
                path.write_text(li.Scene(FALL).text)
            for out in (scene, other):
                with self.assertRaisesRegex(li.InputError, "is not overwritten"):
                    li.Run(str(scene), out=str(out), overwrite=True).finish()
                with self.assertRaisesRegex(li.InputError, "is not overwritten"):
                    li.Run(str(scene)).finish().save(str(out), overwrite=True)
                self.assertEqual(out.read_text(), li.Scene(FALL).text)
            part = Path(folder) / "z.h5.part"
            part.write_text("mine")
            li.Run(str(scene)).finish().save(f"{folder}/z.h5")
            self.assertEqual(part.read_text(), "mine")

    def test_use_after_the_end_is_refused(self):
        run = li.Run(FALL)
        with self.assertRaisesRegex(li.InputError, "has not begun"):
            run.save("x.h5")
        run.finish()
        with self.assertRaisesRegex(li.InputError, "the run has ended"):
            run.frames()
        with self.assertRaisesRegex(li.InputError, "add forces before its first frame"):
            run.add_force(lambda state: 0)
        with tempfile.TemporaryDirectory() as folder:
            path = run.save(f"{folder}/a.h5")
            with self.assertRaisesRegex(li.InputError, "exists"):
                run.save(path)
            self.assertEqual(run.save(path, overwrite=True), path)
            with self.assertRaisesRegex(li.InputError, "cannot be written"):
                run.save(f"{folder}/missing/a.h5")
            self.assertEqual(os.listdir(folder), ["a.h5"])
        with self.assertRaisesRegex(li.InputError, "record=False"):
            li.Run(FALL, record=False).save("x.h5")
        for every in (-1, 0, float("nan"), "0.1"):
            with self.assertRaisesRegex(li.InputError, "output.every"):
                list(li.Run(FALL).frames(every=every))
        run = li.Run(FALL)
        with self.assertRaisesRegex(li.InputError, "by save"):
            for _ in run.frames():
                run.result.close()

    def test_a_result_keeps_its_temporary_file(self):
        result = li.Run(FALL).finish().result
        gc.collect()
        self.assertEqual(len(result["position"]), 5)
        with self.assertRaisesRegex(li.InputError, "temporary file"):
            result.view()

    def test_out_writes_the_file_of_the_command(self):
        with tempfile.TemporaryDirectory() as folder:
            expected = run_command(li.Scene(FALL).text, folder)
            path = f"{folder}/out.h5"
            with li.run(FALL, path) as found:
                self.assertEqual(np.asarray(found["position"]).tolist(), np.asarray(expected["position"]).tolist())
            with self.assertRaises(li.InputError):
                li.run(FALL, path)
            li.run(FALL, path, {"stop.time": 0.1}, overwrite=True).close()
            self.assertEqual(li.load(path).time[-1], 0.1)

    def test_a_failed_run_keeps_its_frames(self):
        def fails_late(state):
            if state.time > 0.12:
                raise ZeroDivisionError("my own")
            return np.zeros((1, 2))
        run = li.Run(FALL)
        run.add_force(fails_late)
        seen = []
        with self.assertRaises(ZeroDivisionError):
            for frame in run.frames():
                seen.append(frame.time)
        self.assertEqual(seen, [0.0, 0.05, 0.1])
        self.assertFalse(run.finished)
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(li.load(run.save(f"{folder}/a.h5")).time.tolist(), seen)

    def test_the_command_refuses_to_resume_without_the_forces(self):
        with tempfile.TemporaryDirectory() as folder:
            run = li.Run(FALL)
            run.add_force(lambda state: np.zeros((1, 2)))
            next(run.frames())
            path = run.save(f"{folder}/part.h5")
            (Path(folder) / "scene.toml").write_text(run.scene.text)
            program = os.environ.get("LICHTENBERG", str(SOURCE / "build/lichtenberg"))
            words = [program, "run", f"{folder}/scene.toml", "--out", path, "--resume"]
            ended = subprocess.run(words, capture_output=True, text=True)
            self.assertEqual(ended.returncode, 2)
            self.assertIn("had python_force, and the scene has no added effects", ended.stderr)

    def test_a_run_that_is_left_can_be_resumed(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = li.Scene(FALL)
            run = li.Run(scene)
            for frame in run.frames():
                if frame.time > 0.08:
                    break
            path = run.save(f"{folder}/part.h5")
            file = Path(folder) / "scene.toml"
            file.write_text(scene.text)
            program = os.environ.get("LICHTENBERG", str(SOURCE / "build/lichtenberg"))
            subprocess.run([program, "run", str(file), "--out", path, "--resume", "--quiet"], check=True)
            expected = run_command(scene.text, folder)
            self.assertEqual(np.asarray(li.load(path)["position"]).tolist(), np.asarray(expected["position"]).tolist())

    def test_two_runs_at_once_are_those_of_one(self):
        settings = {"stop.time": 0.06}

        def positions(results, key):
            results[key] = [frame.position.tolist() for frame in li.Run(SEEDLING, settings, record=False).frames()]
        results = {}
        threads = [threading.Thread(target=positions, args=(results, key)) for key in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        positions(results, 3)
        for key in range(3):
            self.assertEqual(results[key], results[3])
        first, second = (li.Run(FALL, record=False).frames() for _ in range(2))
        for a, b in zip(first, second):
            self.assertEqual(a.position.tolist(), b.position.tolist())

    def test_a_run_that_computes_refuses_other_uses(self):
        run, inside, refused, found = li.Run(FALL, record=False), threading.Event(), threading.Event(), []

        def force(state):
            if not found:
                with self.assertRaisesRegex(li.Failure, "this run is computing"):
                    run._run.time
                inside.set()
                refused.wait(20)
            return np.zeros((1, 2))

        def use():
            inside.wait(20)
            try:
                run._run.next()
            except li.Failure as error:
                found.append(error)
            refused.set()
        run.add_force(force)
        other = threading.Thread(target=use)
        run.add_force(lambda state: np.zeros((1, 2)))
        frames = run.frames()
        inside.clear()
        other.start()
        list(frames)
        other.join()
        self.assertEqual(len(found), 1)

    def test_a_force_may_solve_a_field(self):
        run = li.Run(FALL, record=False)
        energies = set()
        run.add_force(lambda state: (energies.add(li.solve(TWO_DISKS).energy), np.zeros((1, 2)))[1])
        list(run.frames(every=0.2))
        self.assertEqual(len(energies), 1)

    def test_a_forked_process_keeps_the_files_of_its_parent(self):
        run = li.Run(FALL)
        frames = run.frames()
        next(frames)
        child = os.fork()
        if child == 0:
            try:
                run.frames()
                status = 3
            except li.InputError as error:
                status = 0 if "belongs to another process" in str(error) else 4
            finally:
                del frames
            run = None
            gc.collect()
            os._exit(status)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        self.assertEqual(len(list(frames)), 4)

    def test_the_first_use_may_be_in_threads(self):
        program = f"""import sys; sys.path.insert(0, {str(SOURCE / "python")!r})
import threading, lichtenberg
found = []
threads = [threading.Thread(target=lambda: found.append(lichtenberg.solve({TWO_DISKS!r}).energy)) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert len(found) == 4, found"""
        subprocess.run([sys.executable, "-c", program], check=True)

    def test_an_interrupt_ends_a_solve(self):
        # Each solve takes minutes.
        plane = f"{str(SOURCE / 'scenes/dendrite.toml')!r}, {{'field.cells': 2048, 'field.tolerance': 1e-12}}"
        multipole = f"{str(SOURCE / 'scenes/dendrite.toml')!r}, {{'field.method': 'multipole', 'field.tolerance': 1e-12}}"
        space = f"{str(SOURCE / 'scenes/dendrite-3d.toml')!r}, {{'field.accuracy': 1e-8}}"
        for scene in (plane, multipole, space):
            with self.subTest(scene):
                program = textwrap.dedent(f"""
                    import os, signal, sys, threading; sys.path.insert(0, {str(SOURCE / "python")!r})
                    import lichtenberg as li
                    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have let it be ignored
                    li.solve({TWO_DISKS!r})  # loads the module and numpy, which takes time on a busy machine
                    threading.Timer(2, os.kill, (os.getpid(), signal.SIGINT)).start()
                    try:
                        li.solve({scene}, capacitance=True)
                    except KeyboardInterrupt:
                        print("interrupted")
                        print("solved", li.solve({TWO_DISKS!r}).energy > 0)
                    """)
                ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300)
                self.assertEqual(ended.stdout, "interrupted\nsolved True\n", ended.stderr)

    def test_an_interrupt_ends_a_step(self):
        program = textwrap.dedent(f"""
            import sys; sys.path.insert(0, {str(SOURCE / "python")!r})
            import signal
            import lichtenberg as li
            signal.signal(signal.SIGINT, signal.default_int_handler)
            run = li.Run({str(SOURCE / "scenes/dendrite.toml")!r}, {{"output.every": 0.01, "stop.time": 200.0}})
            seen = 0
            try:
                for frame in run.frames():
                    seen += 1
                    if seen == 3:
                        print("begun", flush=True)
            except KeyboardInterrupt:
                found = run.result
                print("interrupted", 0 <= len(found) - seen <= 1, flush=True)
            """)
        # The interrupt may come between the recording of a frame and its count.
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        self.assertEqual(child.stdout.readline(), "begun\n")
        child.send_signal(signal.SIGINT)
        self.assertEqual(child.communicate(timeout=60)[0], "interrupted True\n")


DRIFT = """
#include <cmath>
#include <memory>

#include "src/model/effect.hpp"
#include "src/scene/compiled_effect.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

struct DriftOptions {
  double force = 0;  ///< N along x
  static const EffectKind& kind();
};

class Drift : public Effect {
 public:
  explicit Drift(double force) : force_(force) {}
  const EffectKind& kind() const override { return DriftOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override {
    for_each_requested(state, [&](int i) { force[i * state.bodies.dimension] += force_; });
  }
  double stored_energy(const State& state) const override {
    double energy = 0;
    for (int i = 0; i < state.bodies.size(); ++i) energy -= force_ * state.bodies.position[i * state.bodies.dimension];
    return energy;
  }

 private:
  double force_;
};

const EffectKind& DriftOptions::kind() {
  static const EffectKind kind = {
      .name = "drift",
      .description = "constant force along x",
      .options = DriftOptions{},
      .keys = {{.name = "force", .target = target<&DriftOptions::force>, .unit = "N", .help = "force along x"}},
      .dimensions = {2, 3},
      .make = [](const Scene& scene) { return std::make_unique<Drift>(scene.effects.find<DriftOptions>()->force); }};
  return kind;
}

}  // namespace lichtenberg

LICHTENBERG_EFFECT(lichtenberg::DriftOptions)
"""


class CompiledEffects(unittest.TestCase):
    def test_a_compiled_effect_equals_the_same_force_in_python(self):
        with tempfile.TemporaryDirectory() as folder:
            os.environ["XDG_CACHE_HOME"] = folder
            drift = li.compile_effect(DRIFT)
            self.assertEqual(drift.name, "drift")
            scene = li.Scene({**FALL, "effects": {"stokes_drag": {}, "drift": {"force": 1e-9}}}, compiled=[drift])
            compiled = [frame.position.tolist() for frame in li.Run(scene, record=False).frames()]
            run = li.Run(FALL, record=False)
            run.add_force(lambda state: np.tile([1e-9, 0.0], (len(state.mass), 1)))
            self.assertEqual(compiled, [frame.position.tolist() for frame in run.frames()])
            with self.assertRaises(li.InputError) as caught:
                li.Scene({**FALL, "effects": {"drift": {"force": "strong"}}}, compiled=[drift])
            self.assertEqual(caught.exception.key, "effects.drift.force")
            with self.assertRaisesRegex(li.InputError, "does not compile"):
                li.compile_effect(DRIFT.replace("force_;\n};", "force_\n};"))
            with self.assertRaisesRegex(li.Failure, "no-such-compiler cannot be called"):
                li.compile_effect(DRIFT, compiler="no-such-compiler")
            for compiler in (" ", "c++ '"):
                with self.assertRaises(li.InputError):
                    li.compile_effect(DRIFT, compiler=compiler)
            for source in (None, b"x", "missing.cpp", Path("missing.cpp")):
                with self.assertRaises(li.InputError):
                    li.compile_effect(source)
            with self.assertRaisesRegex(li.InputError, r"no table \[effects.drift\]"):
                li.Scene(FALL, compiled=drift)

    @runs.long
    def test_a_source_without_effect_or_with_a_name_in_use_is_refused(self):
        faults = {"exports no effect": DRIFT.replace("LICHTENBERG_EFFECT(lichtenberg::DriftOptions)", ""),
                  "is built in": DRIFT.replace('"drift"', '"stokes_drag"')}
        with tempfile.TemporaryDirectory() as folder:
            os.environ["XDG_CACHE_HOME"] = folder
            for words, faulty in faults.items():
                with self.assertRaisesRegex(li.InputError, words):
                    li.compile_effect(faulty)

    @runs.long
    def test_a_changed_effect_and_a_changed_header_are_compiled_again(self):
        inline = DRIFT.replace("const EffectKind& DriftOptions", "inline const EffectKind& DriftOptions")
        with tempfile.TemporaryDirectory() as folder:
            os.environ["XDG_CACHE_HOME"] = folder
            first = li.compile_effect(inline)
            second = li.compile_effect(inline.replace("constant force along x", "another one"))
            self.assertEqual((first.description, second.description), ("constant force along x", "another one"))
            header, file = Path(folder) / "words.hpp", Path(folder) / "drift.cpp"
            file.write_text('#include "words.hpp"\n' + DRIFT.replace('"constant force along x"', "WORDS"))
            for words in ("one", "two"):
                header.write_text(f'#define WORDS "{words}"\n')
                self.assertEqual(li.compile_effect(file).description, words)


class Import(unittest.TestCase):
    def test_an_interrupt_while_the_module_is_loaded_leaves_it_usable(self):
        program = textwrap.dedent(f"""
            import sys; sys.path.insert(0, {str(SOURCE / "python")!r})
            import builtins, importlib.util, signal
            import lichtenberg as li
            signal.signal(signal.SIGINT, signal.default_int_handler)
            make, load = importlib.util.module_from_spec, builtins.__import__

            def interrupted(*words, **named):  # an import by the module's initialization
                builtins.__import__ = load
                signal.raise_signal(signal.SIGINT)
                return load(*words, **named)

            def made(found):
                builtins.__import__ = interrupted
                return make(found)
            importlib.util.module_from_spec = made
            try:
                li.solve({TWO_DISKS!r})
            except KeyboardInterrupt:
                importlib.util.module_from_spec = make
                print("interrupted", li.solve({TWO_DISKS!r}).energy > 0)
            """)
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
        self.assertEqual(ended.stdout, "interrupted True\n", ended.stderr)

    def test_import_takes_no_other_package(self):
        program = f"""import sys; sys.path.insert(0, {str(SOURCE / "python")!r}); import lichtenberg
assert not {{"numpy", "h5py", "matplotlib"}} & set(sys.modules)"""
        subprocess.run([sys.executable, "-c", program], check=True)

    def test_solve_and_run_need_no_plotting_package(self):
        program = f"""import sys; sys.path.insert(0, {str(SOURCE / "python")!r}); sys.modules["matplotlib"] = sys.modules["h5py"] = None
import lichtenberg; lichtenberg.solve({TWO_DISKS!r})"""
        subprocess.run([sys.executable, "-c", program], check=True)


if __name__ == "__main__":
    unittest.main()
