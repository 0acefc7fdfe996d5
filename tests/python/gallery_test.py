"""Tests that the page of scenes has the pictures of all requested scenes, and finds all scenes of the table."""
import importlib.util
import os
import subprocess
import unittest

import runs


def gallery():
    specification = importlib.util.spec_from_file_location("gallery", runs.HOME / "scenes/gallery.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


class GalleryTest(unittest.TestCase):
    def test_each_scene_has_a_row(self):
        scenes = {path.stem for path in (runs.HOME / "scenes").glob("*.toml")}
        self.assertEqual({name for name, _ in gallery().rows()}, scenes)

    def test_a_page_with_a_picture(self):
        folder = runs.FOLDER / "gallery"
        command = [runs.HOME / "scenes/gallery.py", folder, "--only", "two-disks,two-grains"]
        ended = subprocess.run(command, env={**os.environ, "LICHTENBERG": runs.PROGRAM}, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        page = (folder / "index.html").read_text()
        for name in ("two-disks", "two-grains"):
            self.assertIn(f'src="{name}.png"', page)
            self.assertTrue((folder / f"{name}.png").read_bytes().startswith(b"\x89PNG"))
        self.assertIn("<code>lichtenberg solve scenes/two-disks.toml --out two-disks.png</code>", page)


if __name__ == "__main__":
    unittest.main()
