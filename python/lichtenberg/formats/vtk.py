"""VTK's XML files, for ParaView: a folder with one file per frame for particles, contacts and tree, and the last
frame's field."""
import re

import numpy as np

from .. import vtk_xml
from ..files import write_whole
from . import columns_of

ENDING, IS_FOLDER = "-vtk", True
KINDS = ("particles", "contacts", "tree")  # of collections and their files


def write(result, frames, folder):
    """Writes particles.pvd, contacts.pvd and tree.pvd with one .vtp file per frame, and field.vti of the last frame."""
    write_steps(result, frames, folder, "particles", lambda frame: [])
    contacts = [index for index in frames if index in result.frames_with_contacts]
    write_steps(result, contacts, folder, "contacts", lambda frame: between_particles(frame.contacts, result.count))
    if "successor" in result.columns:
        write_steps(result, frames, folder, "tree", lambda frame: between_particles(frame.tree, result.count))
    if result.field is not None:
        write_whole(folder / "field.vti", vtk_xml.image_data(result.field_cell, np.asarray(result.field), "potential"))


def write_steps(result, frames, folder, kind, lines_of):
    """Writes one file of particles per frame, with the lines that `lines_of(frame)` returns, and a file that lists
    them, if there are any."""
    listed = []
    for frame in map(result.frame, frames):
        name = f"{kind}-{frame.index:06}.vtp"
        write_whole(folder / name, vtk_xml.poly_data(np.asarray(frame["position"]), columns_of(frame), lines_of(frame), frame.time))
        listed.append((frame.time, name))
    if listed:
        write_whole(folder / f"{kind}.pvd", vtk_xml.collection(listed))


def between_particles(pairs, count):
    """Returns the pairs of particles only: the ground and walls are not points of the file."""
    return pairs[(pairs >= 0).all(axis=1) & (pairs < count).all(axis=1)]


def earlier_files(folder):
    """Returns the names of files of an earlier export to vtk: the collections, the files that they list, and the
    field."""
    found = set()
    for kind in KINDS:
        path = folder / f"{kind}.pvd"
        if path.is_file():
            names = re.findall(r'file="([^"]*)"', path.read_text(encoding="utf-8", errors="replace"))
            found |= {path.name, *(name for name in names if re.fullmatch(rf"{kind}-\d+\.vtp", name))}
    return found | {"field.vti"} if found else found
