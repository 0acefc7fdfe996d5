import subprocess
from pathlib import Path


def shell(command, status=0):
    """Prints a command and its output. Throws AssertionError for another exit status."""
    ended = subprocess.run(command, shell=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(f"$ {command}\n{ended.stdout}")
    assert ended.returncode == status, f"{command} ended with status {ended.returncode}"
