"""Tests of the documentation: links, commands, scene files and keys, quoted messages, lengths of pages.

Tests that need the program are skipped if LICHTENBERG names none.

`docs_test.py --update` writes the sections of scenes in docs/gallery.md. Their data are the expected numbers in
tests/shipped_scenes.json and the times in docs/measurements/gallery.json.
"""
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import textwrap
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
DOCS = HOME / "docs"
sys.path.insert(0, str(DOCS))

import reference  # noqa: E402
import render_measurements  # noqa: E402
import tutorial_scripts  # noqa: E402

PROGRAM = Path(os.environ.get("LICHTENBERG", HOME / "build/lichtenberg"))
MAX_WORDS = 2500
SKIPPED_FOLDERS = {".git", ".cache"}
BEGIN, END = "<!-- begin: tests/language/docs_test.py --update -->", "<!-- end -->"

COMMAND_NAMES = {path.stem.replace("_", "-") for path in (HOME / "python/lichtenberg/commands").glob("[a-z]*.py")}
COMMAND_NAMES |= {"help", "test", "--version", *re.findall(r'return \{\s*"([a-z-]+)",\s', "".join(
    path.read_text() for path in (HOME / "src/commands").glob("*.cpp")))}
COMMAND_NAMES |= set(re.findall(r'Command command\{"([a-z-]+)"', (HOME / "src/commands/network.cpp").read_text()))

# Expected numbers of the gallery, in their order. Counts are exact.
COUNTS = {"connected", "contacts", "rattlers", "collisions"}
QUANTITIES = ["energy", "connected", "contacts", "rattlers", "kinetic_energy", "dissipated_energy", "collisions"]
LEFT_OUT = {"output.picture"}  # settings without an effect on the numbers


def is_built(path):
    """Returns true for paths in build folders and hidden or cached ones."""
    parts = path.relative_to(HOME).parts
    return any(part in SKIPPED_FOLDERS or part == "build" or part.startswith("build-") for part in parts)


def pages(folder=HOME):
    """Returns the Markdown files of a folder, without build folders."""
    return sorted(path for path in folder.rglob("*.md") if not is_built(path))


def without_fences(text):
    """Returns the text without fenced code blocks."""
    return re.sub(r"^```.*?^```[^\n]*$", "", text, flags=re.DOTALL | re.MULTILINE)


def links(text):
    """Returns the targets of the links outside of code."""
    return re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", without_fences(text)))


def anchors(text):
    """Returns the anchors that GitHub and MyST make of the headings."""
    titles = re.findall(r"^#+ (.*)$", without_fences(text), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def commands(text):
    """Returns the words of each command of the program in a page: indented or fenced lines, and inline code."""
    lines = re.sub(r"\\\n\s*", "", text)
    found = re.findall(r"^(?:    |)(?:mpirun -n \d+ )?(?:\./|build/|build-gpu/)lichtenberg (.*)$", lines, re.MULTILINE)
    found += re.findall(r"`(?:\./|build/|build-gpu/)lichtenberg ([^`]*)`", lines)
    return [shlex.split(words.partition(" >")[0], comments=True) for words in found if "..." not in words]


def toml_blocks(text):
    return re.findall(r"^```toml\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def shown(value):
    return f"{value:.4g}"


def expected_number(name, row):
    value = row["values"][name]
    interval = "" if name in COUNTS else f" ± {100 * row['tolerance']:.2g} %"
    return f"{name.replace('_', ' ')} {shown(value)}{interval}"


def scene_sections():
    """Returns the sections of the gallery about each scene: picture, command, time and expected numbers, in Markdown."""
    rows = json.loads((HOME / "tests/shipped_scenes.json").read_text())["rows"]
    drawn = json.loads((DOCS / "measurements/gallery.json").read_text())
    times = {f"{row['scene']}.toml": row for row in drawn["rows"]}
    lines = [wrapped(f"Machine of the times: {drawn['machine']}; {drawn['date']}."), ""]
    for row in sorted(rows, key=lambda each: each["scene"]):
        name, picture = row["scene"], times[row["scene"]]
        settings = [f"`{key}={value}`" for key, value in row["settings"].items() if key not in LEFT_OUT]
        calls = [f"`./{call}`" for call in picture["command"].split("; ")]
        numbers = [expected_number(quantity, row) for quantity in QUANTITIES if quantity in row["values"]]
        items = [f"- Picture: {', then '.join(calls)}.", f"- Time with the picture: {picture['time (s)']:.3g} s.",
                 f"- Test: {', '.join([row['command'], *settings])}.", f"- Expected: {', '.join(numbers)}."]
        lines += [f"### {name}", "", f"![{name}](pictures/{picture['scene']}.png)", "", *map(wrapped, items), ""]
    return "\n".join(lines)


def wrapped(line):
    return textwrap.fill(line, 100, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


def update_gallery():
    page = DOCS / "gallery.md"
    before, rest = page.read_text().split(BEGIN)
    page.write_text(f"{before}{BEGIN}\n{scene_sections()}{END}{rest.split(END)[1]}")


def source_text():
    """Returns the sources. Parts of a string literal are joined, and quotes have no backslash."""
    files = [path for folder in ("src", "solvers", "python") for path in (HOME / folder).rglob("*")
             if path.suffix in (".cpp", ".hpp", ".cu", ".py")]
    return re.sub(r'"\s*\n\s*f?"', "", "".join(path.read_text() for path in files)).replace('\\"', '"')


class Links(unittest.TestCase):
    def test_each_relative_link_resolves(self):
        for page in pages():
            for target in links(page.read_text()):
                if re.match(r"[a-z]+:", target):
                    continue
                name, _, anchor = target.partition("#")
                path = (page.parent / name).resolve() if name else page
                with self.subTest(f"{page.relative_to(HOME)}: {target}"):
                    self.assertTrue(path.exists(), "no such file")
                    if anchor and path.suffix == ".md":
                        self.assertIn(anchor, anchors(path.read_text()))

    def test_each_page_of_the_site_is_reachable(self):
        """From docs/index.md, or from a page outside of docs/."""
        reached, waiting = set(), [DOCS / "index.md", *(page for page in pages() if DOCS not in page.parents)]
        while waiting:
            page = waiting.pop()
            if page in reached:
                continue
            reached.add(page)
            targets = [(page.parent / target.partition("#")[0]).resolve() for target in links(page.read_text())]
            waiting += [target for target in targets if target.suffix == ".md" and target.is_relative_to(DOCS) and target.exists()]
        missing = [str(page.relative_to(HOME)) for page in pages(DOCS) if page not in reached]
        self.assertEqual(missing, [])


class Commands(unittest.TestCase):
    def test_each_command_and_its_scene_exist(self):
        for page in [HOME / "README.md", *pages(DOCS)]:
            text = page.read_text()
            own = {line.partition("\n")[0].removeprefix("# ").strip() for line in toml_blocks(text)}
            for words in commands(text):
                with self.subTest(f"{page.relative_to(HOME)}: {' '.join(words)}"):
                    self.assertIn(words[0], COMMAND_NAMES | {"SCENE", "COMMAND"})
                    for word in words[1:]:
                        if word.endswith(".toml") and word not in own:
                            self.assertTrue((HOME / word).exists(), word)

    def test_gallery_and_scenes_agree(self):
        text = (DOCS / "gallery.md").read_text()
        listed = re.findall(r"^\| ?`([a-z0-9-]+\.toml)` ?\| ?[^`|]", text, re.MULTILINE)
        self.assertEqual(sorted(listed), sorted(path.name for path in (HOME / "scenes").glob("*.toml")))

    def test_pictures_are_small_and_used(self):
        used = {path.name for path in (DOCS / "pictures").glob("*.png")}
        for path in (DOCS / "pictures").iterdir():
            with self.subTest(path.name):
                self.assertLess(path.stat().st_size, 120_000)
        text = "".join(page.read_text() for page in [HOME / "README.md", *pages(DOCS)])
        self.assertEqual(used, set(re.findall(r"pictures/([\w-]+\.png)[)\"]", text)))

    def test_expected_numbers_are_those_of_the_test(self):
        self.assertIn(scene_sections(), (DOCS / "gallery.md").read_text(), "run tests/language/docs_test.py --update")

    @unittest.skipUnless(PROGRAM.exists(), "the program is not built")
    def test_each_scene_of_a_page_is_valid(self):
        for page in pages(DOCS):
            for block in toml_blocks(page.read_text()):
                if not block.startswith("# ") or "[domain]" not in block:  # a part of a scene
                    continue
                with self.subTest(f"{page.relative_to(HOME)}: {block.partition(chr(10))[0]}"):
                    with tempfile.TemporaryDirectory(prefix="lichtenberg-docs-") as folder:
                        scene = Path(folder) / "scene.toml"
                        scene.write_text(block)
                        ended = subprocess.run([PROGRAM, "explain", scene], capture_output=True, text=True, check=False)
                    self.assertEqual(ended.returncode, 0, ended.stderr)
                    self.assertNotIn("old name", ended.stderr)


class Tutorials(unittest.TestCase):
    def test_a_script_has_each_command_and_block_of_its_page(self):
        for page in (DOCS / "tutorials").glob("*.md"):
            if page.name == "index.md":
                continue
            text = page.read_text()
            script = tutorial_scripts.script(text, "tutorials")
            with self.subTest(page.name):
                compile(script, page.name, "exec")
                for command in re.findall(r"^    (\./lichtenberg .*)$", re.sub(r"\\\n\s*", "", text), re.MULTILINE):
                    self.assertIn(f"shell({command!r}", script)
                for block in re.findall(r"^```(?:toml|python)\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
                    self.assertIn(block, script)

    def test_each_tutorial_checks_its_numbers(self):
        for page in (DOCS / "tutorials").glob("*.md"):
            if page.name != "index.md":
                with self.subTest(page.name):
                    self.assertRegex(page.read_text(), r"(?m)^ *assert ")

    def test_prose_becomes_restructured_text(self):
        text = "# Title\n\nSee `a|b`, $x_1$ and [the page](../concepts.md#units), in x_1.\n\n| a | b |\n|---|---|\n|1|`2`|\n|3||\n"
        self.assertEqual(tutorial_scripts.restructured(text, "tutorials"), [
            "Title", "==========", "",
            "See ``a|b``, :math:`x_1` and :doc:`the page </concepts>`, in x\\_1.", "",
            ".. list-table::", "   :header-rows: 1", "", "   * - a", "     - b", "   * - 1", "     - ``2``",
            "   * - 3", "     -", ""])


@unittest.skipUnless(PROGRAM.exists(), "the program is not built")
class Reference(unittest.TestCase):
    def test_each_table_has_a_page_and_each_key_its_type(self):
        with tempfile.TemporaryDirectory(prefix="lichtenberg-docs-") as folder:
            reference.write_scene_reference(PROGRAM, Path(folder) / "scene")
            text = subprocess.run([PROGRAM, "help", "scene"], capture_output=True, text=True, check=True).stdout
            for header in re.findall(r"^(\[\[?[a-z_.]+\]\]?)$", text, re.MULTILINE):
                page = (Path(folder) / "scene" / f"{header.strip('[]').replace('.', '-')}.md").read_text()
                self.assertIn("Kinds of scene: ", page)
                keys = re.split(r"^## ([a-z_]+)$", page, flags=re.MULTILINE)[1:]
                for key, section in zip(keys[::2], keys[1::2]):
                    with self.subTest(f"{header} {key}"):  # meaning, then type, unit, range, default
                        self.assertRegex(section, r"^\n\n[^\n]+\n\n\|[^\n]*\n\|[-|]*\n(?:\| (?:[^|]|\\\|)+ ){4}\|\n")
                listed = re.findall(r"^    (\S+)", text.split(f"\n{header}\n")[1].split("\n\n")[0], re.MULTILINE)
                self.assertEqual(keys[::2], listed)


class Messages(unittest.TestCase):
    def test_each_quoted_message_is_in_the_code(self):
        sources = source_text()
        for message in re.findall(r"^\| ?`(.*?)` ?\|", (DOCS / "errors.md").read_text(), re.MULTILINE):
            for part in filter(None, (part.strip() for part in message.split("..."))):
                with self.subTest(message):
                    self.assertIn(part, sources)


class Lengths(unittest.TestCase):
    def test_no_page_is_too_long(self):
        for page in [HOME / "README.md", *pages(DOCS)]:
            with self.subTest(page.relative_to(HOME)):
                self.assertLessEqual(len(without_fences(page.read_text()).split()), MAX_WORDS)

    def test_all_pages_together_are_short(self):
        """Generated pages and parts do not count."""
        generated = {DOCS / f"{name}.md" for name in render_measurements.written_pages()}
        texts = [page.read_text().split(BEGIN)[0] for page in pages(DOCS) if page not in generated]
        self.assertLessEqual(sum(len(without_fences(text).split()) for text in texts), 35_000)

    def test_the_readme_is_short(self):
        self.assertLessEqual(len((HOME / "README.md").read_text().split()), 450)

    def test_a_how_to_is_short(self):
        for page in (DOCS / "how-to").glob("*.md"):
            if page.name != "index.md":
                with self.subTest(page.name):
                    self.assertLessEqual(len(without_fences(page.read_text()).split()), 200)


if __name__ == "__main__":
    if sys.argv[1:] == ["--update"]:
        update_gallery()
    else:
        unittest.main()
