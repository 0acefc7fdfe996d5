"""Tests of the measurements of `work-precision` and of its output."""
import math
import os
import time
import unittest
from types import SimpleNamespace
from unittest import mock

import runs  # This module adds the package's path.
from lichtenberg import Failure, InputError
from lichtenberg.commands.work_precision import Sweep, measure_all
from lichtenberg.methods import Method, freefem
from lichtenberg.pictures import drawing, film
from lichtenberg.pictures.fields import Fields
from lichtenberg.questions import Program
from lichtenberg.work_precision_report import cheapest_points, printed, to_json


class SleepMethod(Method):
    """Method that sleeps for a given time and has a given error."""

    def __init__(self, name, candidates):
        self.name, self.sleep_candidates = name, candidates  # ({"cost": cost}, cost), s, error.

    def candidates(self, sweep):
        return [candidate for candidate, _, _ in self.sleep_candidates]

    def prepare(self, sweep, settings):
        seconds, error = next((s, e) for (own, _), s, e in self.sleep_candidates if own == settings)
        if isinstance(error, Exception):
            raise error
        return lambda: (error, time.sleep(seconds))  # The clock measures the seconds.


class SleepSweep(Sweep):
    def __init__(self, methods):
        self.methods = [(method.name, "", method.candidates(self), method) for method in methods]
        self.program = SimpleNamespace(ask=lambda errors: {"errors": [errors]})
        self.points, self.left_out = [], []
        self.about = {"scene": "nap.toml", "title": "naps", "processor": "any", "cores": 1, "load": 0.0, "versions": "0"}
        self.about |= {"errors": "given", "reference": "none", "work": "naps", "time": "wall time"}
        self.about |= {"quantities": ["positions"], "reference_errors": [1e-9]}


def sleep_candidate(cost, seconds, error):
    return ({"cost": cost}, cost), seconds, error


def point(name, error, seconds):
    return {"method": name, "settings": {}, "errors": [error], "seconds": seconds, "cores": 1.0, "work": 1}


class Prices(unittest.TestCase):
    def test_the_cheapest_of_those_that_are_good_enough_is_named_decade_by_decade(self):
        points = [point("rough", 0.05, 1), point("dear", 0.02, 5), point("good", 0.004, 2), point("best", 2e-3, 3)]
        prices = cheapest_points(points, 0, 0)
        self.assertEqual([found and found["method"] for _, found in prices], ["rough", "good", None])
        self.assertAlmostEqual(prices[2][0], 1e-3)

    def test_no_price_is_named_for_less_than_the_references_own_error(self):
        prices = cheapest_points([point("lucky", 1e-6, 1)], 0, 0.03)
        self.assertEqual([found is None for _, found in prices], [False, True])

    def test_prices_of_what_has_no_error_at_all_end_where_numbers_do(self):
        prices = cheapest_points([point("exact", 0, 1)], 0, 0)
        self.assertEqual(len(prices), 16)
        self.assertIsNotNone(prices[-1][1])


class Measuring(unittest.TestCase):
    def test_what_would_take_too_long_is_not_begun_and_what_fails_does_not_end_the_sweep(self):
        begun = AssertionError("it was begun")
        sleeper = SleepMethod("sleeper", [sleep_candidate(1, 2e-3, 0.1), sleep_candidate(1e9, 0, begun), sleep_candidate(2, 2e-3, math.nan)])
        picky = SleepMethod("picky", [sleep_candidate(1, 0, InputError("no disks")), sleep_candidate(2, 1e-3, 0.01)])
        sweep = SleepSweep([sleeper, picky])
        # The trials sleep for milliseconds; the limit allows for a busy machine.
        measure_all(sweep, 1000, lambda *_: None)
        self.assertEqual([p["method"] for p in sweep.points], ["sleeper", "picky"])
        self.assertGreaterEqual(sweep.points[0]["seconds"], 2e-3)
        reasons = [entry["reason"] for entry in sweep.left_out]
        self.assertEqual(reasons, ["expected to take longer than 1000 s", "unstable", "no disks"])

    def test_json_and_table_hold_all_that_was_measured(self):
        sweep = SleepSweep([SleepMethod("only", [])])
        sweep.points = [point("only", 1e-3, 0.25)]
        sweep.left_out = [{"method": "other", "settings": {"S": 64.0}, "reason": "no disks"}]
        data = to_json(sweep)
        self.assertEqual(data["points"][0]["errors"], {"positions": 1e-3})
        self.assertEqual(data["left_out"][0]["settings"]["S"], 64)
        self.assertEqual(len(data["prices"]["positions"]), 3)
        text = printed(sweep)
        self.assertRegex(text, r"only +1\.0e-03 +250 +1\.00 +1")
        self.assertIn("other                     no disks", text)
        self.assertIn("1e-4    none is that good", text)


class Processes(unittest.TestCase):
    def test_the_death_of_the_program_that_answers_is_a_failure_with_a_sentence(self):
        for end, sentence in (("kill -KILL $$", "the signal Killed has ended it"), ("exit 0", "it has ended")):
            path = runs.FOLDER / "dying"
            path.write_text(f"#!/bin/sh\n{end}\n")
            path.chmod(0o755)
            with mock.patch.dict(os.environ, LICHTENBERG=str(path)), self.assertRaisesRegex(Failure, sentence):
                Program("any").read()

    def test_fields_of_more_frames_than_an_argument_can_hold_are_asked_for(self):
        frames = range(100_000)  # Linux permits 128 KiB per argument. This result has no field, so no solve starts.
        with mock.patch.dict(os.environ, LICHTENBERG=runs.PROGRAM):
            self.assertIsNone(Fields(runs.gas(), frames).values())

    def test_a_picture_that_cannot_be_written_is_a_failure(self):
        with self.assertRaisesRegex(Failure, "cannot be written"):
            drawing.save(None, str(runs.FOLDER / "nowhere/picture.png"))
        with self.assertRaisesRegex(Failure, "cannot be written"):
            film.Ffmpeg(str(runs.FOLDER / "nowhere/film.mp4"), (2, 2), 15)


class FreeFem(unittest.TestCase):
    # An isolated sphere: the integral of the squared field gradient is 4 pi times its radius (Jackson 1999, section
    # 1.11).
    SPHERE = {"permittivity": 4e-11, "spheres": [{"radius": 2e-3, "group": 0}]}
    INTEGRALS = [4 * math.pi, 0, 0, 0, *[0] * 12, 0.5]

    def answer(self, **group):
        subject = {**self.SPHERE, "groups": [group]}
        return freefem.answer_of(subject, [str(number) for number in self.INTEGRALS])

    def test_potential_and_charge_of_a_sphere_are_those_of_coulombs_law(self):
        capacitance = 4 * math.pi * 4e-11 * 2e-3
        floating, seconds = self.answer(floating=True, charge=1e-12, potential=0)
        self.assertAlmostEqual(floating["potential"][0] * capacitance / 1e-12, 1, places=12)
        held, _ = self.answer(floating=False, charge=0, potential=50)
        self.assertAlmostEqual(held["charge"][0] / (capacitance * 50), 1, places=12)
        self.assertEqual((held["force"], seconds), ([[0, 0, 0]], 0.5))

    def test_results_that_are_not_complete_are_a_failure(self):
        with self.assertRaisesRegex(Failure, "not complete"):
            freefem.answer_of({**self.SPHERE, "groups": [{}]}, ["1", "2"])


class CandidatesOfJoinedMethods(unittest.TestCase):
    def test_an_error_or_a_cost_of_0_leaves_the_method_out(self):
        class Wrong(Method):
            name = "wrong"

        sweep = Sweep.__new__(Sweep)
        sweep.left_out = []
        self.assertEqual(sweep.candidates_of(Wrong()), [])  # The method has no candidates().
        Wrong.candidates = lambda self, sweep: [({"S": 32}, 0)]
        self.assertEqual(sweep.candidates_of(Wrong()), [])
        self.assertIn("NotImplementedError in the method", sweep.left_out[0]["reason"])
        self.assertIn("a cost that is not above 0", sweep.left_out[1]["reason"])
        Wrong.candidates = lambda self, sweep: [({"S": 32}, 1)]
        self.assertEqual(sweep.candidates_of(Wrong()), [({"S": 32}, 1)])


if __name__ == "__main__":
    unittest.main()
