"""Wrong Python commands from outside, and words that Python itself interprets: one error message each."""
import os
import subprocess
import sys
import unittest

import runs

sys.path.insert(0, str(runs.HOME / "tests/extension"))
import python_command_test as outside  # The module, whose own tests do not run again.

COUNT, IMPORT = outside.COUNT, outside.IMPORT


class WrongCommands(outside.Outside, unittest.TestCase):
    def test_a_module_that_is_no_command_is_a_failure(self):
        self.check_failure("HELP =\n", "SyntaxError in ")
        self.check_failure("import nowhere\n", "there is no Python package nowhere")
        self.check_failure("HELP, ARGUMENTS = 'x', []\n", "it has no act")
        self.check_failure("HELP, ARGUMENTS = 3, []\ndef act(request): pass\n", "HELP is a text")
        self.check_failure(f"raise SystemExit(3)\n{COUNT}", "it ends Python when it is imported")
        rules = ("'number'", "colour='red'", "result='drawn'", "positive=True", "'flag', default=True", "allowed=[1]", "required=1",
                 "'int', value_optional=True", "excluded='--y'")
        for rule in rules:
            self.check_failure(f"{IMPORT}ARGUMENTS = [argument('--x', '', {rule})]\nact = print\n", "argument --x: ")

    def test_words_that_it_prints_when_imported_do_not_spoil_its_table(self):
        (runs.FOLDER / "commands/chatty.py").write_text(f"print('hello')\n{COUNT}")
        self.assertEqual(runs.program("chatty", runs.gas())[0], 0)

    def test_an_error_of_its_code_is_one_sentence_and_no_fault_of_the_file(self):
        code = {"nothing": "NameError", "result.nothing": "AttributeError", "{}['x']": "KeyError", "1 / 0": "ZeroDivisionError",
                "open('/nowhere/x', 'w')": "FileNotFoundError"}
        for expression, kind in code.items():
            self.check_failure(COUNT.replace("print(result.count)", f"print({expression})"), f"{kind} in ", runs.gas())

    def test_python_applies_the_rules_of_arguments_as_the_program_does(self):
        words = [sys.executable, "-m", "lichtenberg"]
        (runs.FOLDER / "commands/two.py").write_text(
            f"{IMPORT}ARGUMENTS = [argument('--x', 'y'), argument('--z', 'y', excluded='--x')]\ndef act(request): pass\n")
        for name, sentence, *rest in (
            ("two", "argument --z: not allowed with argument --x", "--x=1", "--z=2"),
            ("two", "--x is given twice, and once is allowed", "--x=1", "--x=2"),
            ("work-precision", "inf is not allowed: it must be a finite number", "x.toml", "--seconds", "inf"),
            ("ensemble", "-1 is not allowed: it must be a finite number above 0", "x.toml", "--jobs", "-1"),
            ("ensemble", "--device tpu is not allowed: it must be cpu, cuda, or for several devices ", "x.toml", "--device=tpu"),
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

    def test_a_missing_package_is_named_in_one_sentence(self):
        words = [sys.executable, "-S", str(runs.HOME / "python/lichtenberg/__main__.py"), "view", runs.gas()]  # -S: Python alone
        ended = subprocess.run(words, capture_output=True, text=True, env={}, check=False)
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertRegex(ended.stderr, r"\Alichtenberg: there is no Python package (h5py|numpy), .*: install it\n\Z")

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


if __name__ == "__main__":
    unittest.main()
