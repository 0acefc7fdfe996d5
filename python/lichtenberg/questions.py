"""A process of the program that answers requests as lines of JSON."""
import json
import signal
import subprocess

from .errors import Failure
from .installation import find_program


class Program:
    """`words`: a command of the program for requests (src/commands/json_output.hpp), and its arguments. `own_session`: an
    interruption from the keyboard does not reach the process."""

    def __init__(self, *words, own_session=False):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8"}
        self.process = subprocess.Popen([find_program(), *words], start_new_session=own_session, **pipes)

    def read(self):
        """Returns the next answer. If the program has ended with a status, it has printed why: this process ends with the same
        status. Throws Failure if a signal has ended it."""
        line = self.process.stdout.readline()
        if not line:
            status = self.process.wait()
            if status > 0:
                raise SystemExit(status)
            ended = f"the signal {signal.strsignal(-status)} has ended it" if status else "it has ended"
            raise Failure(f"the process of the program that answers questions is gone: {ended}")
        return json.loads(line)

    def ask(self, **question):
        try:
            self.process.stdin.write(json.dumps(question) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # read() determines the cause
        return self.read()
