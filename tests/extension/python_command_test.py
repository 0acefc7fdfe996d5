"""Command added from outside by one file in Python."""
import os
import sys
import unittest
from pathlib import Path
from unittest import mock

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "python"))
import runs

COUNT = '''"""`lichtenberg count`."""
from lichtenberg.commands import argument
from lichtenberg.errors import InputError

HELP = "Counts the bodies of a result"
ARGUMENTS = [
    argument("RESULT", "result file of a run (.h5)", required=True, result="counted"),
    argument("--least", "fewer bodies than this are refused", "int"),
]


def act(request):
    from lichtenberg import load

    with load(request.result) as result:
        if request.least is not None and result.count < request.least:
            raise InputError(f"{request.result}: too few bodies")
        print(result.count)
'''

IMPORT = "from lichtenberg.commands import argument\nHELP = ''\n"


class Outside:
    """Mixin of a TestCase: the folder of LICHTENBERG_COMMANDS contains `count`."""

    def setUp(self):
        folder = runs.FOLDER / "commands"
        folder.mkdir(exist_ok=True)
        (folder / "count.py").write_text(COUNT)
        environment = mock.patch.dict(os.environ, LICHTENBERG_COMMANDS=str(folder))
        environment.start()
        self.addCleanup(environment.stop)

    def check_refused(self, sentence, *words):
        status, output, complaint = runs.program(*words)
        self.assertEqual((status, output), (2, ""))
        self.assertIn(sentence, complaint)
        self.assertEqual(complaint.count("\n"), 1)
        self.check_plain(complaint)

    def check_plain(self, complaint):
        """Checks that no exception of Python, h5py or C++ libraries is printed as such."""
        for words in ("Traceback", "Error:", "json.exception", "Unable to", "errno"):
            self.assertNotIn(words, complaint)

    def check_failure(self, text, sentence, *words):
        (runs.FOLDER / "commands/broken.py").write_text(text)
        status, output, complaint = runs.program("broken", *words)
        self.assertEqual((status, output), (1, ""), complaint)
        self.assertIn(sentence, complaint)
        self.assertEqual(complaint.count("\n"), 1)
        self.check_plain(complaint)


class CommandFromOutside(Outside, unittest.TestCase):
    def test_it_is_run_with_the_words_that_the_program_has_read(self):
        self.assertEqual(runs.program("count", runs.gas()), (0, "60\n", ""))
        self.assertEqual(runs.program("count", "--least=60", runs.gas()), (0, "60\n", ""))

    def test_its_own_refusal_and_those_of_the_program_are_one_sentence(self):
        self.check_refused("gas.h5: too few bodies", "count", runs.gas(), "--least", 61)
        self.check_refused("RESULT is required; see `lichtenberg help count` for the allowed arguments", "count")
        self.check_refused("count has no option --lest; did you mean --least?", "count", runs.gas(), "--lest=1")
        (runs.FOLDER / "no.h5").write_text("nothing")
        self.check_refused("no.h5", "count", "no.h5")

    def test_help_explains_it(self):
        status, output, _ = runs.program("help", "count")
        self.assertEqual(status, 0)
        self.assertIn("Counts the bodies of a result", output)
        self.assertIn("--least INT", output)

    def test_a_command_may_have_options_only(self):
        act = "def act(request): print(request.x)\n"
        (runs.FOLDER / "commands/options.py").write_text(f"{IMPORT}ARGUMENTS = [argument('--x', 'y', 'int')]\n{act}")
        self.assertEqual(runs.program("options", "--x=4"), (0, "4\n", ""))
        self.assertEqual(runs.program("options"), (0, "None\n", ""))

    def test_neither_the_working_folder_nor_a_safe_path_of_python_matters(self):
        for name in ("json", "numpy", "lichtenberg"):
            (runs.FOLDER / f"{name}.py").write_text("raise SystemExit(9)\n")
            self.addCleanup((runs.FOLDER / f"{name}.py").unlink)
        for safe in ("", "1"):
            with mock.patch.dict(os.environ, PYTHONSAFEPATH=safe):
                self.assertEqual(runs.program("count", runs.gas()), (0, "60\n", ""))

    def test_a_name_that_no_module_has_is_refused(self):
        self.check_refused("there is no command `cound`", "cound")
        self.check_refused("there is no command `plit`; did you mean `plot`?", "plit")


if __name__ == "__main__":
    unittest.main()
