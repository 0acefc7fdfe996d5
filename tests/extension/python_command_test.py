"""A command that the program does not have, from outside, by one file in Python."""
import os
import subprocess
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


class CommandFromOutside(unittest.TestCase):
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
        """No exception of Python, h5py or C++ libraries is shown as such."""
        for words in ("Traceback", "Error:", "json.exception", "Unable to", "errno"):
            self.assertNotIn(words, complaint)

    def test_it_is_run_with_the_words_that_the_program_has_read(self):
        self.assertEqual(runs.program("count", runs.gas()), (0, "60\n", ""))
        self.assertEqual(runs.program("count", "--least=60", runs.gas()), (0, "60\n", ""))

    def test_neither_the_working_folder_nor_a_safe_path_of_python_matters(self):
        for name in ("json", "numpy", "lichtenberg"):
            (runs.FOLDER / f"{name}.py").write_text("raise SystemExit(9)\n")
            self.addCleanup((runs.FOLDER / f"{name}.py").unlink)
        for safe in ("", "1"):
            with mock.patch.dict(os.environ, PYTHONSAFEPATH=safe):
                self.assertEqual(runs.program("count", runs.gas()), (0, "60\n", ""))

    def test_its_own_refusal_and_those_of_the_program_are_one_sentence(self):
        self.check_refused("gas.h5: too few bodies", "count", runs.gas(), "--least", 61)
        self.check_refused("RESULT is required; `lichtenberg help count` says what is allowed", "count")
        self.check_refused("count has no option --lest; did you mean --least?", "count", runs.gas(), "--lest=1")
        (runs.FOLDER / "no.h5").write_text("nothing")
        self.check_refused("no.h5", "count", "no.h5")

    def test_help_explains_it(self):
        status, output, _ = runs.program("help", "count")
        self.assertEqual(status, 0)
        self.assertIn("Counts the bodies of a result", output)
        self.assertIn("--least INT", output)

    def check_failure(self, text, sentence, *words):
        (runs.FOLDER / "commands/broken.py").write_text(text)
        status, output, complaint = runs.program("broken", *words)
        self.assertEqual((status, output), (1, ""), complaint)
        self.assertIn(sentence, complaint)
        self.check_plain(complaint)

    def test_a_module_that_is_no_command_is_a_failure(self):
        self.check_failure("HELP =\n", "broken.py is no command in Python")
        self.check_failure("import nowhere\n", "there is no Python package nowhere")
        self.check_failure("HELP, ARGUMENTS = 'x', []\n", "it has no act")
        self.check_failure("HELP, ARGUMENTS = 3, []\ndef act(request): pass\n", "HELP is a text")
        for rule in ("'number'", "colour='red'", "result='drawn'"):
            self.check_failure(f"{IMPORT}ARGUMENTS = [argument('--x', '', {rule})]\n", "argument --x: ")

    def test_an_error_of_its_code_is_one_sentence_and_no_fault_of_the_file(self):
        for expression, kind in (("nothing", "NameError"), ("result.nothing", "AttributeError")):
            self.check_failure(COUNT.replace("print(result.count)", f"print({expression})"), f"{kind} in ", runs.gas())

    def test_python_applies_the_rules_of_arguments_as_the_program_does(self):
        words = [sys.executable, "-m", "lichtenberg"]
        for name, sentence, *rest in (
            ("ensemble", "-1 is not allowed: it must be a number above 0", "x.toml", "--jobs", "-1"),
            ("ensemble", "tpu is not allowed: it is one of cpu, cuda", "x.toml", "--device=tpu"),
            ("ensemble", "the value is empty", "x.toml", "--out="),
            ("work-precision", "invalid int value: '32,x'", "x.toml", "--sizes", "32,x"),
            ("../count", "there is no command `../count` in Python"),
        ):
            ended = subprocess.run([*words, name, *rest], capture_output=True, text=True, cwd=runs.FOLDER,
                                   env={**os.environ, "PYTHONPATH": str(runs.HOME / "python")}, timeout=60)
            self.assertEqual((ended.returncode, ended.stdout), (2, ""), ended.stderr)
            self.assertIn(sentence, ended.stderr)
            self.assertEqual(ended.stderr.count("\n"), 1)
            self.check_plain(ended.stderr)

    def test_options_for_petsc_are_refused(self):
        self.check_refused("count passes no options to PETSc", "count", runs.gas(), "--petsc", "-ksp_view")

    def test_a_folder_or_another_file_in_place_of_a_result_is_refused(self):
        (runs.FOLDER / "no.h5").write_text("nothing")
        for command in ("count", "film", "view", "plot", "analyse"):
            self.check_refused("no.h5", command, "no.h5")
        for command in ("count", "film", "view", "analyse"):
            self.check_refused(". is ", command, ".")
        self.check_refused("name a result file or the folder of an ensemble", "plot", ".")

    def test_positional_numbers_may_be_negative(self):
        table = "ARGUMENTS = [argument(*each) for each in (('A', '', 'int'), ('B', '', 'float'), ('--c', '', 'int'))]\n"
        act = "def act(request): print(request.a, request.b, request.c)\n"
        (runs.FOLDER / "commands/numbers.py").write_text(IMPORT + table + act)
        self.assertEqual(runs.program("numbers", "--c=-3", "--", "-5", "-1e-5"), (0, "-5 -1e-05 -3\n", ""))

    def test_a_name_that_no_module_has_is_refused(self):
        self.check_refused("there is no command `cound`", "cound")
        self.check_refused("there is no command `plit`; did you mean `plot`?", "plit")


if __name__ == "__main__":
    unittest.main()
