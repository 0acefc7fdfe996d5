"""Version of the tree, and the checks of packaging/release, in a repository of four files."""
import importlib.machinery
import importlib.util
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import runs

SCRIPT = runs.HOME / "packaging/release"
FILES = {
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.25)\nproject(lichtenberg VERSION 1.2.3 LANGUAGES C CXX)\n",
    "CHANGELOG.md": "# Changes\n\n## 1.2.3\n\n- new\n\n## 1.2.2\n",
    "CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.3\n",
    ".gitignore": "build-*/\n",
}


def load_script(path=SCRIPT):
    loader = importlib.machinery.SourceFileLoader("release", str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("release", loader))
    loader.exec_module(module)
    return module


class VersionTest(unittest.TestCase):
    def test_all_files_of_the_tree_and_the_program_state_one_version(self):
        number = load_script().agreed_version(runs.HOME)
        self.assertRegex(number, r"^\d+\.\d+\.\d+$")
        self.assertEqual(runs.program("--version")[1].split()[:2], ["lichtenberg", number])

    def test_recipes_state_the_version_of_the_tree(self):
        number = load_script().agreed_version(runs.HOME)
        for name, pattern in {"conda/meta.yaml": r'set version = "(.+)"', "spack/spack_repo/lichtenberg/packages/lichtenberg/package.py": r'version\("(\d.*?)"'}.items():
            stated = re.search(pattern, (runs.HOME / "packaging" / name).read_text())
            self.assertEqual(stated and stated[1], number, name)


DEP5 = "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\n\n"


@unittest.skipUnless(shutil.which("dpkg-query"), "this is no Debian machine")
class BillOfMaterialsTest(unittest.TestCase):
    """Licences of the dependencies (packaging/bill_of_materials.py)."""

    def setUp(self):
        self.script = load_script(runs.HOME / "packaging/bill_of_materials.py")

    def test_every_dependency_has_a_version_and_an_allowed_licence(self):
        bill = self.script.bill(runs.PROGRAM)
        packages = (runs.HOME / "cmake/debian-packages.txt").read_text().split("\n", 1)[1].split()
        names = {entry["name"] for entry in bill["components"]}
        self.assertLessEqual(set(packages), names)
        self.assertTrue(any(name.startswith("libfftw3-double") for name in names))  # the program names this library
        for entry in bill["components"]:
            self.assertTrue(entry["version"] and entry["licenses"], entry["name"])
        # FFTW and SuiteSparse are under the GPL, which therefore applies to binaries (README.md).
        self.assertRegex(bill["metadata"]["properties"][0]["value"], r"^GPL-3\.0-or-later, because of .*cholmod.*, libfftw3")

    def test_unknown_and_incompatible_licences_are_refused_by_name(self):
        for licence in ("GPL-2", "CC-BY-NC-4.0", "Expat and GPL-2", "BSD-4-clause"):
            with self.subTest(licence), self.assertRaisesRegex(self.script.Refused, f'libx has files under the licence "{licence}"'):
                self.script.allowed("libx", licence)
        for licence, identifier in {"GPL-2+": "GPL-2.0-or-later", "GPL-2 or Expat": "MIT", "LGPL-2.1+ or MPL-2": "LGPL-2.1-or-later"}.items():
            self.assertEqual(self.script.allowed("libx", licence), identifier)

    def test_licences_of_the_packaging_are_left_out(self):
        files = "Files: *\nCopyright: 1\nLicense: Expat\n\nFiles: debian/*\nCopyright: 2\nLicense: GPL-2\n\nLicense: Expat\n text\n"
        self.assertEqual(self.script.stated_licences(DEP5 + files), {"Expat"})
        self.assertEqual(self.script.stated_licences(files), set())


@unittest.skipUnless(shutil.which("git"), "git is missing")
class ReleaseTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="lichtenberg-release-")
        self.addCleanup(scratch.cleanup)
        self.tree = Path(scratch.name) / "tree"
        (self.tree / "packaging").mkdir(parents=True)
        shutil.copy(SCRIPT, self.tree / "packaging/release")
        for name, text in FILES.items():
            (self.tree / name).write_text(text)
        self.git("init", "-q")
        self.commit()

    def git(self, *words):
        who = ["-c", "user.name=test", "-c", "user.email=test@localhost"]
        return subprocess.run(["git", "-C", self.tree, *who, *words], capture_output=True, text=True, check=True).stdout

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", "Change the tree")

    def release(self, *words):
        return subprocess.run([self.tree / "packaging/release", *words], capture_output=True, text=True, check=False)

    def check_refused(self, *texts):
        ended = self.release("--dry-run")
        self.assertEqual((ended.returncode, ended.stdout), (2, ""))
        self.assertEqual(ended.stderr.count("\n"), 1)
        for text in texts:
            self.assertIn(text, ended.stderr)

    def test_a_dry_run_prints_the_commands_and_changes_nothing(self):
        ended = self.release("--dry-run")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        for text in ("archive --prefix=lichtenberg-1.2.3/", "-DLICHTENBERG_NATIVE=OFF", "cpack -G DEB", "pip wheel", "lichtenberg-1.2.3.cdx.json", "SHA256SUMS"):
            self.assertIn(text, ended.stdout)
        self.assertNotIn("tag", ended.stdout)
        self.assertEqual(self.git("status", "--porcelain", "--ignored"), "")

    def test_a_changed_or_untracked_file_is_refused_by_name(self):
        (self.tree / "CHANGELOG.md").write_text(FILES["CHANGELOG.md"] + "\n")
        self.check_refused("has 1 changed or untracked files, as CHANGELOG.md")
        self.commit()
        (self.tree / "notes.txt").write_text("")
        self.check_refused("as notes.txt")

    def test_other_versions_and_unreleased_ones_are_refused(self):
        for name, old, new in (
            ("CITATION.cff", "1.2.3", "1.2.2"),
            ("CHANGELOG.md", "## 1.2.3", "## 1.2.3, unreleased"),
            ("CHANGELOG.md", "## 1.2.3\n", ""),
        ):
            with self.subTest(name, new=new):
                (self.tree / name).write_text(FILES[name].replace(old, new))
                self.commit()
                self.check_refused(name, 'CMakeLists.txt states "1.2.3"')
                (self.tree / name).write_text(FILES[name])
                self.commit()

    def test_changes_of_no_version_are_refused(self):
        text = FILES["CHANGELOG.md"].replace("## 1.2.3", "## Unreleased\n\n- newer\n\n## 1.2.3")
        (self.tree / "CHANGELOG.md").write_text(text)
        self.commit()
        self.check_refused("CHANGELOG.md has a section Unreleased: move its lines to the section of the version")

    def test_a_file_without_a_version_is_refused(self):
        (self.tree / "CITATION.cff").write_text("title: lichtenberg\n")
        self.commit()
        self.check_refused("CITATION.cff states no version")

    def test_a_folder_with_files_is_not_overwritten(self):
        ended = self.release("--dry-run", "--out", str(self.tree))
        self.assertEqual(ended.returncode, 2)
        self.assertIn("is not an empty folder", ended.stderr)

    def test_an_unpacked_archive_states_its_commit_without_git(self):
        shutil.copytree(runs.HOME / "cmake", self.tree / "cmake")
        shutil.copy(runs.HOME / ".gitattributes", self.tree)
        (self.tree / "cmake/commit.txt").write_text("$Format:%H$\n")  # this tree may be unpacked from an archive itself
        (self.tree / "template").write_text("@commit@")
        self.commit()
        archive = subprocess.run(["git", "-C", self.tree, "archive", "--prefix=unpacked/", "HEAD"], capture_output=True, check=True)
        subprocess.run(["tar", "-x", "-C", self.tree], input=archive.stdout, check=True)

        def stated(source):
            words = {"SOURCE": source, "TEMPLATE": source / "template", "OUTPUT": source / "output"}
            options = [word for name, value in words.items() for word in ("-D", f"{name}={value}")]
            subprocess.run(["cmake", *options, "-P", source / "cmake/version.cmake"], capture_output=True, check=True)
            return (source / "output").read_text().strip()

        self.assertEqual(stated(self.tree / "unpacked"), self.git("rev-parse", "HEAD")[:12])
        shutil.rmtree(self.tree / ".git")
        self.assertEqual(stated(self.tree), "unknown")

    def test_a_step_that_fails_ends_it_with_status_1(self):
        ended = self.release()  # this tree's languages need sources, and it has no target
        self.assertEqual(ended.returncode, 1)
        self.assertIn("ended with status", ended.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
