"""A process of the program that answers questions, in lines of JSON."""
import json
import subprocess

from .installation import find_program


class Program:
    """`words`: a command of the program that is for this (src/commands/json_output.hpp), and its arguments. `apart`: an
    interruption from the keyboard does not reach it."""

    def __init__(self, *words, apart=False):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8"}
        self.process = subprocess.Popen([find_program(), *words], start_new_session=apart, **pipes)

    def read(self):
        """Ends as the program does if it has no more to say: its sentence is on standard error."""
        line = self.process.stdout.readline()
        if not line:
            status = self.process.wait()
            raise SystemExit(status if status > 0 else 1)
        return json.loads(line)

    def ask(self, **question):
        try:
            self.process.stdin.write(json.dumps(question) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # read() finds out why
        return self.read()
