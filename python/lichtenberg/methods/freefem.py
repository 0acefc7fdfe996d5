"""Finite elements on a field of spheres, by FreeFEM on meshes by Gmsh."""
import math
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from ..errors import Failure, InputError
from . import Method

LABEL = 10  # of the first sphere; sides have 1 to 6
MOST = 12  # spheres that are meshed
SLACK = 1e-3

# The program solves one field for each group, with the group at potential 1 and all else at 0. It solves one more with the
# sides at their potentials and all groups at 0. Then it integrates products of two gradients over the volume and, with the
# normal, over each sphere.
PROGRAM = """mesh3 Th = readmesh3("box.mesh");
fespace Vh(Th, P2);
real before = clock();
Vh[int] field(FIELDS);
int j = 0;
Vh u, v;
problem laplace(u, v, solver = CG, eps = 1e-20) = int3d(Th)(dx(u)*dx(v) + dy(u)*dy(v) + dz(u)*dz(v))CONDITIONS;
for (j = 0; j < FIELDS; ++j) { u = 0; laplace; field[j] = u; }
ofstream out("integrals");
out.precision(17);
for (int a = 0; a < FIELDS; ++a) for (int b = 0; b < FIELDS; ++b)
  out << int3d(Th)(dx(field[a])*dx(field[b]) + dy(field[a])*dy(field[b]) + dz(field[a])*dz(field[b])) << endl;
for (int i = LABEL; i < LABEL + SPHERES; ++i) for (int a = 0; a < FIELDS; ++a) for (int b = 0; b < FIELDS; ++b) {
  Vh product = dx(field[a])*dx(field[b]) + dy(field[a])*dy(field[b]) + dz(field[a])*dz(field[b]);
  out << int2d(Th, i)(product*N.x) << " " << int2d(Th, i)(product*N.y) << " " << int2d(Th, i)(product*N.z) << endl;
}
out << clock() - before << endl;
"""


class Freefem(Method):
    name, kind = "freefem", "spheres"
    description = "finite elements (P2) by FreeFEM on meshes by Gmsh, which take time that is not counted"

    def candidates(self, sweep):
        return [({"edge / R": size}, size**-4) for size in (0.6, 0.4, 0.25, 0.15)]

    def prepare(self, sweep, settings):
        check(sweep.subject)
        folder = tempfile.TemporaryDirectory(prefix="lichtenberg-")
        path = Path(folder.name)
        (path / "box.geo").write_text(geometry(sweep.subject, settings["edge / R"]), encoding="utf-8")
        (path / "field.edp").write_text(program(sweep.subject), encoding="utf-8")
        call(folder, ["gmsh", "-3", "-format", "mesh", "-o", "box.mesh", "box.geo"], "Gmsh made no mesh of the spheres")

        def run():
            call(folder, ["FreeFem++", "-nw", "-v", "0", "field.edp"], "FreeFEM did not get through it")
            return answer_of(sweep.subject, (path / "integrals").read_text(encoding="utf-8").split())

        return run


def check(subject):
    for command in ("FreeFem++", "gmsh"):
        if not shutil.which(command):
            raise InputError(f"there is no command `{command}` (Debian's packages freefem and gmsh)")
    if not 1 <= len(subject["spheres"]) <= MOST:
        raise InputError(f"1 to {MOST} spheres are meshed, not {len(subject['spheres'])}")
    if not subject["closed"]:
        raise InputError("meshes have insulating and electrode sides only")
    if not subject["ground"]:
        raise InputError("an insulated box has no level for the finite elements")
    if subject["dielectrics"]:
        raise InputError("dielectric spheres are not meshed")


def call(folder, words, sentence):
    with open(Path(folder.name) / "out", "w", encoding="utf-8") as out:
        streams = {"stdin": subprocess.DEVNULL, "stdout": out, "stderr": out}
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        if subprocess.run(words, cwd=folder.name, env=environment, check=False, **streams).returncode != 0:
            raise Failure(sentence)


def smallest_radius(subject):
    return min(sphere["radius"] for sphere in subject["spheres"])


def geometry(subject, size):
    """For Gmsh: the box without the spheres, lengths in smallest radii, edges `size` long at the spheres."""
    unit = smallest_radius(subject)
    box = [length / unit for length in subject["box"]]
    spheres = [([x / unit for x in sphere["centre"]], sphere["radius"] / unit) for sphere in subject["spheres"]]
    text = 'SetFactory("OpenCASCADE");\n' + f"Box(1) = {{0, 0, 0, {listed(box)}}};\n"
    for i, (centre, radius) in enumerate(spheres):
        text += f"Sphere({i + 2}) = {{{listed(centre)}, {radius}}};\n"
    holes = f"{{ Volume{{2:{len(spheres) + 1}}}; Delete; }}"
    text += f"BooleanDifference(100) = {{ Volume{{1}}; Delete; }}{holes};\nPhysical Volume(1) = {{100}};\n"
    for side in range(6):
        low, high = [0.0, 0.0, 0.0], list(box)
        (low if side % 2 else high)[side // 2] = box[side // 2] if side % 2 else 0.0
        text += surface_in(1 + side, low, high, SLACK)
    for i, (centre, radius) in enumerate(spheres):
        text += surface_in(LABEL + i, centre, centre, radius + SLACK)
        text += f"MeshSize{{ PointsOf{{ Surface{{s{LABEL + i}()}}; }} }} = {size};\n"
    text += f"Mesh.MeshSizeMax = {6 * size};\nMesh.MeshSizeFromCurvature = {2 * math.pi / size:.0f};\n"
    return text + "Mesh.SaveElementTagType = 2;\n"


def listed(numbers):
    return ", ".join(map(str, numbers))


def surface_in(label, low, high, slack):
    corners = listed([x - slack for x in low] + [x + slack for x in high])
    return f"s{label}() = Surface In BoundingBox{{{corners}}};\nPhysical Surface({label}) = {{s{label}()}};\n"


def program(subject):
    groups, spheres = len(subject["groups"]), subject["spheres"]
    conditions = "".join(f" + on({LABEL + i}, u = (j == {sphere['group']}))" for i, sphere in enumerate(spheres))
    for side, potential in enumerate(subject["side_potential"]):
        if potential is not None:
            conditions += f" + on({1 + side}, u = (j == {groups}) * {potential:.17g})"
    values = {"FIELDS": groups + 1, "CONDITIONS": conditions, "LABEL": LABEL, "SPHERES": len(spheres)}
    text = PROGRAM
    for name, value in values.items():
        text = text.replace(name, str(value))
    return text


def answer_of(subject, words):
    """Potentials from the groups' charges and potentials, then charges and forces, whose integrals are eps V^2 whatever the unit
    of length; and FreeFEM's seconds."""
    import numpy as np

    groups, spheres, n = subject["groups"], subject["spheres"], len(subject["groups"])
    fields = (n + 1) ** 2
    if len(words) != fields * (1 + 3 * len(spheres)) + 1:
        raise Failure("FreeFEM's results are not complete")
    *values, seconds = np.array(words, float)
    products = np.reshape(values[:fields], (n + 1, n + 1))
    integrals = np.reshape(values[fields:], (len(spheres), n + 1, n + 1, 3))
    scale = subject["permittivity"] * smallest_radius(subject)
    matrix, right = products[:n, :n].copy(), np.empty(n)
    for g, group in enumerate(groups):
        right[g] = group["charge"] / scale - products[g, n] if group["floating"] else group["potential"]
        if not group["floating"]:
            matrix[g] = np.eye(n)[g]
    potential = np.append(np.linalg.solve(matrix, right), 1)
    charge = scale * products @ potential
    members = [sphere["group"] for sphere in spheres]
    force = -0.5 * subject["permittivity"] * np.einsum("a,b,iabk->ik", potential, potential, integrals)
    charges = [float(charge[g]) if members.count(g) == 1 else None for g in members]
    return {"potential": potential[:n].tolist(), "charge": charges, "force": force.tolist()}, float(seconds)
