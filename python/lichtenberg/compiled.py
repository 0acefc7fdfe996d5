"""Effects in C++ that are compiled while Python runs. Such an effect has the speed of a built-in one, because the same
templates generate its loops. A Python function is slower: it is called for all bodies at once, outside of these loops."""
import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import core
from .errors import Failure, InputError


def include_folder():
    """Returns the folder of the headers: of the source, or as installed."""
    here = Path(__file__).resolve().parent
    for folder in (here / "../..", here / "../../../../include/lichtenberg"):
        if (folder / "src/scene/effect_kind.hpp").is_file():
            return folder.resolve()
    raise Failure("the headers of lichtenberg were not found: install them, or use the package of the source")


def cache_folder():
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(base) / "lichtenberg"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def compile_effect(source, compiler=None):
    """Compiles an effect and returns it, for Scene(..., effects=[effect]).

    source: C++ code that defines an effect (docs/developers/extending.md), or the path of a file with such code. The code ends
        with LICHTENBERG_EFFECT(OPTIONS).

    compiler: the C++ compiler. Default: CXX of the environment, else c++.

    A library is compiled once and kept in the user's cache folder. Throws InputError for code that does not compile or exports
    no effect, Failure without a compiler."""
    code = Path(source).read_text(encoding="utf-8") if is_path(source) else str(source)
    words = shlex.split(compiler or os.environ.get("CXX", "c++"))
    if not shutil.which(words[0]):
        raise Failure(f"the compiler {words[0]} was not found: install one, or name one by compiler=")
    module = core.load()
    flags = [word for word in module.compiler_flags.split() if not word.startswith("-fsanitize")]
    command = [*words, "-std=c++20", *flags, "-fPIC", "-shared", f"-I{include_folder()}"]
    identity = "\n".join([code, *command, module.version, str(os.stat(module.__file__).st_mtime_ns)])
    library = cache_folder() / f"effect-{hashlib.sha256(identity.encode()).hexdigest()[:24]}.so"
    if not library.exists():
        build(code, command, library, module.__file__)
    return module.load_effect(str(library))


def is_path(source):
    return isinstance(source, os.PathLike) or "\n" not in str(source) and str(source).endswith((".cpp", ".cc", ".hpp"))


def build(code, command, library, module):
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        file, made = Path(folder) / "effect.cpp", Path(folder) / "effect.so"
        file.write_text(code, encoding="utf-8")
        ended = subprocess.run([*command, str(file), module, "-o", str(made)], capture_output=True, text=True, check=False)
        if ended.returncode:
            errors = [line for line in ended.stderr.splitlines() if "error" in line] or ended.stderr.splitlines()
            raise InputError(f"the effect does not compile: {errors[0] if errors else 'no message'}")
        os.replace(made, library)  # two processes may compile at once
