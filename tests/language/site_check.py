#!/usr/bin/env python3
"""Checks that the site of docs/ builds without warnings, broken links and missing pages. The tutorials are not executed.

The exit status is 77 if Sphinx or a package of the site is not installed.
"""
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
DOCS = HOME / "docs"
PROGRAM = Path(os.environ.get("LICHTENBERG", HOME / "build/lichtenberg"))
PACKAGES = ("sphinx", "myst_parser", "furo", "h5py", "numpy")
UNREACHABLE = "http://127.0.0.1:9"  # proxy of each connection, so that the build fails if it needs a network


def site_builder():
    sys.path.insert(0, str(DOCS))
    return importlib.import_module("build_site")


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="lichtenberg-site-")
        cls.addClassCleanup(folder.cleanup)
        cls.site = Path(folder.name) / "html"
        environment = {**os.environ, "http_proxy": UNREACHABLE, "https_proxy": UNREACHABLE}
        command = [sys.executable, "-B", DOCS / "build_site.py", PROGRAM, folder.name, "--fast"]
        cls.ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    def test_build_has_no_warnings_and_no_broken_links(self):
        self.assertEqual((self.ended.returncode, self.ended.stderr), (0, ""))

    def test_contents_have_each_page(self):
        targets = set(site_builder().Page(self.site / "index.html").targets)
        pages = [page.relative_to(DOCS).with_suffix(".html").as_posix() for page in DOCS.rglob("*.md")]
        self.assertEqual([page for page in pages if page != "index.html" and page not in targets], [])

    def test_site_is_searchable(self):
        self.assertIn("contact_distance", (self.site / "searchindex.js").read_text())

    def test_reference_has_tables_commands_and_libraries(self):
        library = ["cpp/field", "cpp/network"] if shutil.which("doxygen") and importlib.util.find_spec("breathe") else []
        for name in ["scene/field", "commands/solve", "python", *library]:
            with self.subTest(name):
                self.assertTrue((self.site / f"reference/{name}.html").exists())


class Links(unittest.TestCase):
    def test_missing_files_and_anchors_are_found(self):
        with tempfile.TemporaryDirectory(prefix="lichtenberg-site-") as folder:
            site = Path(folder)
            (site / "a.html").write_text('<p id="here"><a href="b.html#there"></a><a href="#here"></a><img src="c.png">'
                                         '<a href="https://example.org/none"></a>')
            (site / "b.html").write_text('<a href="a.html#here"></a><a href="a.html#nowhere"></a>')
            self.assertEqual(site_builder().broken_links(site),
                             ["a.html: no anchor b.html#there", "a.html: no file c.png", "b.html: no anchor a.html#nowhere"])


if __name__ == "__main__":
    missing = [name for name in PACKAGES if not importlib.util.find_spec(name)]
    if missing:
        print(f"skipped: {', '.join(missing)} of Python not installed", file=sys.stderr)
        sys.exit(77)
    unittest.main()
