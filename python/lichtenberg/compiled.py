"""Effects in C++ that are compiled while Python runs. Such an effect has the speed of a built-in one, because the same
templates generate its loops. A Python function is slower: it is called for all bodies at once, outside of these loops."""
import hashlib
import os
import platform
import shlex
import subprocess
import tempfile
from pathlib import Path

from . import core
from .errors import Failure, InputError

ENDINGS = (".cpp", ".cc", ".cxx", ".hpp")


def include_folder():
    """Returns the folder of the headers: of the source, of a wheel, or as installed."""
    here = Path(__file__).resolve().parent
    for folder in (here / "../..", here / "include", here / "../../../../include/lichtenberg"):
        if (folder / "src/scene/effect_kind.hpp").is_file():
            return folder.resolve()
    raise Failure("the headers of lichtenberg were not found: install them, or use the package of the source")


def cache_folder():
    """Returns a folder for libraries: the user's cache, or a temporary one if that cannot be written."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lichtenberg"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    return Path(tempfile.mkdtemp(prefix="lichtenberg-"))


def compile_effect(source, compiler=None):
    """Compiles an effect and returns it, for Scene(..., compiled=[effect]).

    source: C++ code that defines an effect (docs/developers/extending.md), or the path of a file with such code. The code ends
        with LICHTENBERG_EFFECT(OPTIONS).

    compiler: the C++ compiler. Default: CXX of the environment, else c++.

    A library is compiled once for each code with its headers, compiler and processor, and kept in the user's cache folder.
    Throws InputError for code that does not compile or exports no effect, Failure without a compiler."""
    module = core.load()
    try:
        words = shlex.split(compiler or os.environ.get("CXX") or "c++")
    except ValueError as error:
        raise InputError(f"the compiler {compiler!r} is no command ({error})") from None
    if not words:
        raise InputError("the compiler is an empty text: name one, or leave it out")
    # Without this flag GCC gives the static variable of an inline kind() to the process, and a second version of an effect
    # would be the first.
    only_here = ["-fno-gnu-unique"] if output([*words, "--version"]).find("clang") < 0 else []
    command = [*words, "-std=c++20", *module.compiler_flags.split(), *only_here, "-fPIC", f"-I{include_folder()}"]
    with tempfile.TemporaryDirectory(prefix="lichtenberg-") as folder:
        file = source_file(source, folder)
        expanded = output([*command, "-E", str(file)])
        parts = [expanded, *command, output([*words, "--version"]), processor(), str(os.stat(module.__file__).st_mtime_ns)]
        library = cache_folder() / f"effect-{hashlib.sha256(chr(10).join(parts).encode()).hexdigest()[:24]}.so"
        if not library.exists():
            build([*command, "-shared", str(file), module.__file__], library)
    try:
        return module.load_effect(str(library))
    except Failure:
        library.unlink(missing_ok=True)  # incomplete, for example
        raise


def source_file(source, folder):
    """Returns the path of the code: the given file, or a new file in the folder."""
    if isinstance(source, os.PathLike) or isinstance(source, str) and "\n" not in source and source.endswith(ENDINGS):
        if not Path(source).is_file():
            raise InputError(f"{source} is no file with C++ code")
        return Path(source).resolve()
    if not isinstance(source, str):
        raise InputError(f"a {type(source).__name__} is no C++ code: give a text or a path")
    file = Path(folder) / "effect.cpp"
    file.write_text(source, encoding="utf-8")
    return file


def output(command):
    """Returns the standard output of the compiler. Throws InputError with its first errors."""
    try:
        ended = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    except OSError as error:
        raise Failure(f"the compiler {command[0]} cannot be called ({error.strerror}): install one, or name one by compiler=") from None
    if ended.returncode:
        lines = [line for line in ended.stderr.splitlines() if "error" in line] or ended.stderr.splitlines() or ["no message"]
        raise InputError("the effect does not compile: " + "; ".join(lines[:3]))
    return ended.stdout


def processor():
    """Returns the processor for which -march=native compiles."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.machine()
    return platform.machine() + next((line for line in lines if line.startswith(("flags", "Features"))), "")


def build(command, library):
    """Compiles into a temporary file and renames it, because two processes may compile at once."""
    handle, made = tempfile.mkstemp(suffix=".so", dir=library.parent)
    os.close(handle)
    try:
        output([*command, "-o", made])
        os.replace(made, library)
    finally:
        Path(made).unlink(missing_ok=True)
