"""The module in the interpreter's process: scenes, solves, runs, forces from Python, and bad input."""
import os
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
from lichtenberg import core

if core.find_module() is None:
    print("module_test: the module is not built (pybind11-dev is missing): skipped")
    sys.exit(77)

TWO_DISKS = str(SOURCE / "scenes/two-disks.toml")
FALL = {  # one disk without forces of its own
    "domain": {"size": [1e-2, 1e-2]},
    "medium": {"permittivity": 1.0, "viscosity": 1e-3},
    "material": {"density": 1000.0},
    "effects": {"stokes_drag": {}},
    "conductor": [{"position": [5e-3, 5e-3], "radius": 1e-3}],
    "stop": {"time": 0.2, "stationary": False},
    "output": {"every": 0.05, "picture": False},
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

    def test_bad_sources_are_refused(self):
        for source in (3, [1], b"x", object()):
            with self.assertRaises(li.InputError):
                li.Scene(source)
        with self.assertRaises(li.InputError):
            li.Scene()
        with self.assertRaises(li.InputError):
            li.Scene(FALL, domain={"size": [1, 1]})
        with self.assertRaises(li.InputError):
            li.Scene("missing.toml")
        with self.assertRaises(li.InputError):
            li.Scene(TWO_DISKS, "no setting")
        with self.assertRaises(li.InputError):
            li.Scene({**FALL, "seed": object()})
        with self.assertRaises(li.InputError):
            li.conductors(np.zeros(3), radius=1e-3)
        with self.assertRaises(li.InputError):
            li.Scene({**FALL, "conductor": li.conductors(np.full((1, 2), np.nan), radius=1e-3)})

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
        self.assertEqual(set(vars(found)), set(expected) - {"conductors"} | {
            "position", "radius", "group", "potential", "charge", "force"})

    def test_potential_field(self):
        found = li.solve(TWO_DISKS, {"field.cells": 64}, potential_field=True)
        self.assertEqual(found.potential_field.unit, "V")
        self.assertEqual(max(found.potential_field.shape), 64)
        self.assertTrue(np.isfinite(found.potential_field).all())

    def test_grains_have_their_units(self):
        found = li.solve(str(SOURCE / "scenes/two-grains.toml"))
        self.assertEqual(found.force.shape, (2, 3))
        self.assertEqual(found.force.unit, "m0 v0^2/d0")
        self.assertEqual(li.solve(str(SOURCE / "scenes/pair-3d.toml")).force.shape, (2, 3))

    def test_scenes_without_a_field_are_refused(self):
        with self.assertRaises(li.InputError):
            li.solve(FALL)
        with self.assertRaises(li.InputError):
            li.solve(TWO_DISKS, device="tpu")

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
        for _ in range(50):
            solve_one()
        before = resident()
        for _ in range(200):
            solve_one()
        self.assertLess(resident() - before, 2e6)  # a leak of one grid (64 x 64 doubles) per solve is 6.5e6


class Runs(unittest.TestCase):
    def test_frames_and_file_are_those_of_the_command(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = li.Scene(str(SOURCE / "scenes/seedling.toml"), {"stop.time": 0.1, "output.picture": False})
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
        self.assertAlmostEqual((frames[-1].position[0, 0] - 5e-3) / moved, 1, delta=1e-3)
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

    def test_the_state_is_read_only(self):
        run = li.Run(FALL, record=False)

        @run.add_force
        def force(state):
            state.position[0, 0] = 0
            return np.zeros((1, 2))
        with self.assertRaises(ValueError):
            list(run.frames())

    def test_use_after_the_end_is_refused(self):
        run = li.Run(FALL)
        run.finish()
        with self.assertRaises(li.InputError):
            list(run.frames())
        with self.assertRaises(li.InputError):
            run.add_force(lambda state: 0)
        with tempfile.TemporaryDirectory() as folder:
            path = run.save(f"{folder}/a.h5")
            with self.assertRaises(li.InputError):
                run.save(path)
            with self.assertRaises(li.InputError):
                run.save(f"{folder}/missing/a.h5")
        with self.assertRaises(li.InputError):
            li.Run(FALL, record=False).save("x.h5")
        with self.assertRaises(li.InputError):
            li.Run(TWO_DISKS, {"effects.floating_conductors": {}}).frames(every=-1).__next__()

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
            self.assertEqual(li.load(path).time[-1], 0.2)

    def test_two_runs_at_once_are_those_of_one(self):
        def positions(results, key):
            results[key] = [frame.position.tolist() for frame in li.Run(FALL, record=False).frames()]
        results = {}
        threads = [threading.Thread(target=positions, args=(results, key)) for key in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        positions(results, 3)
        self.assertEqual(results[0], results[3])
        self.assertEqual(results[1], results[3])
        first, second = li.Run(FALL, record=False).frames(), li.Run(FALL, record=False).frames()
        for a, b in zip(first, second):
            self.assertEqual(a.position.tolist(), b.position.tolist())

    def test_one_run_in_two_threads_is_refused(self):
        run = li.Run(FALL, record=False)
        inside, found = threading.Event(), []

        def force(state):
            if not inside.is_set():
                inside.set()
                try:
                    next(run._core_frames())
                except li.Failure as error:
                    found.append(error)
            return np.zeros((1, 2))
        run.add_force(force)
        run._core_frames = lambda: iter([run._run.next()])
        list(run.frames())
        self.assertEqual(len(found), 1)

    def test_an_interrupt_ends_a_step(self):
        program = textwrap.dedent(f"""
            import sys; sys.path.insert(0, {str(SOURCE / "python")!r})
            import lichtenberg as li
            run = li.Run({str(SOURCE / "scenes/dendrite.toml")!r}, {{"output.every": 100.0, "stop.time": 200.0}}, record=False)
            try:
                for frame in run.frames():
                    print("begun", flush=True)
            except KeyboardInterrupt:
                print("interrupted", flush=True)
            """)
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        self.assertEqual(child.stdout.readline(), "begun\n")
        child.send_signal(signal.SIGINT)
        self.assertEqual(child.communicate(timeout=60)[0], "interrupted\n")


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
            scene = li.Scene({**FALL, "effects": {"stokes_drag": {}, "drift": {"force": 1e-9}}}, effects=[drift])
            compiled = [frame.position.tolist() for frame in li.Run(scene, record=False).frames()]
            run = li.Run(FALL, record=False)
            run.add_force(lambda state: np.tile([1e-9, 0.0], (len(state.mass), 1)))
            self.assertEqual(compiled, [frame.position.tolist() for frame in run.frames()])
            with self.assertRaises(li.InputError) as caught:
                li.Scene({**FALL, "effects": {"drift": {"force": "strong"}}}, effects=[drift])
            self.assertEqual(caught.exception.key, "effects.drift.force")
            for faulty in (DRIFT.replace("force_;\n};", "force_\n};"), DRIFT.replace("LICHTENBERG_EFFECT(", "static_assert(sizeof "),
                           DRIFT.replace('"drift"', '"stokes_drag"')):
                with self.assertRaises(li.InputError):
                    li.compile_effect(faulty)
            with self.assertRaises(li.Failure):
                li.compile_effect(DRIFT, compiler="no-such-compiler")


class Import(unittest.TestCase):
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
