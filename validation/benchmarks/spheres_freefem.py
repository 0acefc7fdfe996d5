#!/usr/bin/python3
"""Compares finite elements with the solver of spheres on one scene.

    spheres_freefem.py build/validation [--sizes 0.03,0.02,0.012]

The finite elements are FreeFEM's (P2, conjugate gradients) on meshes by Gmsh. The scene is s4_box3 of
data/reference-spheres: three floating spheres in a unit box on an electrode. Prints the error of the potentials,
relative to the largest, and seconds without meshing: FreeFEM's processor time for the three fields of the capacitance
matrix, and the time that `validation spheres long` prints. Reports if FreeFem++ or gmsh is missing.
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

CASE = "s4_box3"
DATA = pathlib.Path(__file__).resolve().parent.parent / "data" / "reference-spheres" / f"{CASE}.json"


def geometry(scene, size):
    """Returns Gmsh input: the box without the spheres, refined near them; labels 1 (electrode) and 10 + k (sphere k).
    """
    lines = ['SetFactory("OpenCASCADE");', "Box(1) = {0, 0, 0, 1, 1, 1};"]
    for k, s in enumerate(scene["spheres"]):
        lines.append(f"Sphere({k + 2}) = {{{s['x']}, {s['y']}, {s['z']}, {s['R']}}};")
    last = len(scene["spheres"]) + 1
    lines.append(f"BooleanDifference(100) = {{ Volume{{1}}; Delete; }}{{ Volume{{2:{last}}}; Delete; }};")
    lines.append("e = 1e-3;\nPhysical Surface(1) = Surface In BoundingBox{-e, -e, -e, 1 + e, 1 + e, e};")
    for k, s in enumerate(scene["spheres"]):
        low = ", ".join(f"{s[a]} - {s['R']} - e" for a in "xyz")
        high = ", ".join(f"{s[a]} + {s['R']} + e" for a in "xyz")
        lines.append(f"s{k}() = Surface In BoundingBox{{{low}, {high}}};\nPhysical Surface({10 + k}) = {{s{k}()}};")
        lines.append(f"MeshSize{{ PointsOf{{ Surface{{s{k}()}}; }} }} = {size};")
    lines.append("Physical Volume(1) = {100};")
    lines.append(f"Mesh.MeshSizeMax = {4 * size};\nMesh.SaveElementTagType = 2;")
    return "\n".join(lines)


def program(mesh, spheres):
    """Returns a FreeFEM program: the field of each sphere at 1 V with all else at 0, and the mutual energies of pairs.
    """
    conditions = " + ".join(f"on({10 + k}, u = (j == {k}))" for k in range(spheres))
    return f"""
mesh3 Th = readmesh3("{mesh}");
fespace Vh(Th, P2);
real before = clock();
Vh[int] field({spheres});
int j = 0;
Vh u, v;
problem laplace(u, v, solver = CG, eps = 1e-20) = int3d(Th)(dx(u)*dx(v) + dy(u)*dy(v) + dz(u)*dz(v))
  + on(1, u = 0) + {conditions};
for (j = 0; j < {spheres}; ++j) {{ u = 0; laplace; field[j] = u; }}
cout << "unknowns " << Vh.ndof << endl;
for (int a = 0; a < {spheres}; ++a) for (int b = 0; b < {spheres}; ++b)
  cout << "C " << int3d(Th)(dx(field[a])*dx(field[b]) + dy(field[a])*dy(field[b]) + dz(field[a])*dz(field[b])) << endl;
cout << "seconds " << clock() - before << endl;
"""


def by_elements(scene, size, folder):
    (folder / "box.geo").write_text(geometry(scene, size))
    subprocess.run(["gmsh", "-3", "-v", "1", "-format", "mesh", "-o", folder / "box.mesh", folder / "box.geo"], check=True)
    spheres = len(scene["spheres"])
    (folder / "box.edp").write_text(program(folder / "box.mesh", spheres))
    out = subprocess.run(["FreeFem++", "-nw", "-v", "0", folder / "box.edp"], check=True, capture_output=True, text=True).stdout
    matrix = np.array([float(x) for x in re.findall(r"^C (\S+)", out, re.M)]).reshape(spheres, spheres)
    charge = np.array([c["Q"] for c in scene["conductors"]])
    exact = np.array(scene["reference"]["phi_sphere"])
    error = np.abs(np.linalg.solve(matrix, charge) - exact).max() / np.abs(exact).max()
    return int(re.search(r"unknowns (\d+)", out)[1]), error, float(re.search(r"seconds (\S+)", out)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ours")
    parser.add_argument("--sizes", default="0.03,0.02,0.012")
    arguments = parser.parse_args()
    print(f"{'':<24}{'error of potentials':>20}{'seconds':>12}")
    ours = subprocess.run([arguments.ours, "spheres", "long"], check=True, capture_output=True, text=True).stdout
    for degree, iterations, seconds, error in re.findall(
            CASE + r": degree (\d+), (\d+) iterations, (\S+) s\n.*\npotentials +(\S+)", ours):
        print(f"{'ours, degree ' + degree:<24}{float(error):>20.2g}{float(seconds):>12.4f}")
    missing = [name for name in ("FreeFem++", "gmsh") if not shutil.which(name)]
    if missing:
        sys.exit(f"the peer is missing: apt-get install {' '.join(n.lower() for n in missing)}")
    scene = json.loads(DATA.read_text())
    for size in arguments.sizes.split(","):
        with tempfile.TemporaryDirectory() as folder:
            unknowns, error, seconds = by_elements(scene, float(size), pathlib.Path(folder))
        print(f"{f'FreeFEM, {unknowns} unknowns':<24}{error:>20.2g}{seconds:>12.2f}")


main()
