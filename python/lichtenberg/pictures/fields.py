"""The potential around the conductors in frames of a result, solved again from the data in the frames."""
import os
import subprocess
import tempfile

import numpy as np

from ..errors import Failure
from ..installation import find_program


class Fields:
    """Potentials of several frames, which the program computes (frame_fields.cpp) in parallel with this process.
    `frames`: indices, which it reads from its standard input."""

    def __init__(self, path, frames, quiet=True):
        self.memory = os.memfd_create("fields")
        words = [find_program(), "frame-fields", *["--quiet"] * quiet, "--", path]
        with tempfile.TemporaryFile("w+", encoding="ascii") as indices:  # not as an argument, whose length is limited
            indices.write("\n".join(map(str, frames)))
            indices.seek(0)
            self.process = subprocess.Popen(words, stdin=indices, stdout=self.memory)

    def values(self):
        """Returns [frames, ny, nx] V, with NaN for a frame that cannot be solved; None for a run without a field.
        Throws Failure."""
        if self.process.wait() != 0:
            raise Failure("the fields of the frames were not solved (see the program's message above)")
        path = f"/proc/self/fd/{self.memory}"
        if os.path.getsize(path) == 0:
            return None
        nx, ny = np.fromfile(path, np.int32, 2)
        return np.memmap(path, np.float32, "r", offset=8).reshape(-1, ny, nx)
