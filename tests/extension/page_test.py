"""Checks that the C++ blocks of docs/developers/extending.md compile, each in the code that surrounds it.

The compiler and its flags are those of an extension test in the build of the program that LICHTENBERG names.
"""
import json
import os
import re
import shlex
import subprocess
import tempfile
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
PAGE = HOME / "docs/developers/extending.md"
MODEL = "extension_tests.dir/Unity/unity_0_cxx.cxx"
COMMANDS = Path(os.environ.get("LICHTENBERG", HOME / "build/lichtenberg")).parent / "compile_commands.json"

HEADERS = ("src/effects/device_forces.hpp", "src/effects/device_pair.hpp", "src/model/drive_part.hpp",
           "src/model/effect.hpp", "src/model/frame.hpp", "src/model/pair_effect.hpp", "src/scene/effect_kind.hpp",
           "src/scene/sharing_law.hpp")
DRIVE = """
struct DriveLaw { LICHTENBERG_HOST_DEVICE void operator()(double, double, int, double, double*, int) const; };
struct MyOptions { static DriveLaw law(const Scene&); };
"""
SOFT = """
struct SoftOptions {
  static const EffectKind& kind();
  static SoftLaw law(const Scene&);
};
"""
# Code around each block of the page, in their order; @ is the block. The first block ends its namespace.
SURROUNDINGS = (
    "@\nnamespace lichtenberg::effects {",
    "@",
    SOFT + 'const EffectKind soft{.name = "soft", @};',
    "struct Drag : Updraft {\n  struct { double coefficient; } options;\n  @\n};",
    DRIVE + 'const EffectKind drive{.name = "drive", @};',
    'const EffectKind sharing{.name = "sharing", @};',
    "struct Gaps : Updraft {\n@\n};\n}",
)


def source():
    """Returns a C++ source with all blocks of the page."""
    blocks = re.findall(r"^```cpp\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    if len(blocks) != len(SURROUNDINGS):
        raise AssertionError(f"{PAGE} has {len(blocks)} C++ blocks, and this test has code around {len(SURROUNDINGS)}")
    lines = ["#include <cmath>", *(f'#include "{header}"' for header in HEADERS)]
    blocks[0] = blocks[0].replace("#pragma once\n", "")
    return "\n".join(lines + [text.replace("@", block) for text, block in zip(SURROUNDINGS, blocks)]) + "\n"


@unittest.skipUnless(COMMANDS.exists(), "the build has no compile_commands.json")
class Page(unittest.TestCase):
    def test_each_block_compiles(self):
        command, = [entry["command"] for entry in json.loads(COMMANDS.read_text()) if entry["file"].endswith(MODEL)]
        words = shlex.split(command)
        kept = [word for word in words[: words.index("-o")] if not word.startswith("-I")]
        for flag in ("-include", "-Winvalid-pch"):  # the source needs no precompiled header
            if flag in kept:
                at = kept.index(flag)
                del kept[at : at + (2 if flag == "-include" else 1)]
        with tempfile.TemporaryDirectory(prefix="lichtenberg-page-") as folder:
            file = Path(folder) / "page.cpp"
            file.write_text(source())
            ended = subprocess.run([*kept, f"-I{HOME}", "-fsyntax-only", file], capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)


if __name__ == "__main__":
    unittest.main()
