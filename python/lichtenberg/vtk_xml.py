"""VTK's XML files: .vtp of points and lines, .vti of a grid, .pvd that lists them by time. Arrays are deflated, in base64."""
import base64
import zlib

import numpy as np

TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}
HEAD = '<?xml version="1.0"?>\n<VTKFile type="{}" version="1.0" byte_order="LittleEndian" header_type="UInt64"{}>\n'
DEFLATED = ' compressor="vtkZLibDataCompressor"'


def encoded(values):
    """Returns an array as one compressed block: number of blocks, block length, length of the last block (0: same as
    the others), compressed length; then the block."""
    data = values.tobytes()
    if not data:
        return base64.b64encode(np.zeros(1, "<u8").tobytes()).decode()
    block = zlib.compress(data)
    head = np.array([1, len(data), 0, len(block)], "<u8").tobytes()
    return base64.b64encode(head).decode() + base64.b64encode(block).decode()


def array(name, values, more=""):
    values = np.ascontiguousarray(values)
    kind = values.dtype.str[1:]
    components = values.shape[1] if values.ndim > 1 else 1
    about = f'type="{TYPES[kind]}" Name="{name}" NumberOfComponents="{components}" format="binary"{more}'
    return f"<DataArray {about}>{encoded(values.astype(values.dtype.newbyteorder('<')))}</DataArray>\n"


def arrays(tag, columns, **marks):
    marked = "".join(f' {mark}="{name}"' for mark, name in marks.items() if name in columns)
    return f"<{tag}{marked}>\n{''.join(array(name, values) for name, values in columns.items())}</{tag}>\n"


def cells(tag, points):
    """Returns cells of VTK from [M, k] indices of points, one row per cell."""
    ends = np.arange(1, len(points) + 1, dtype=np.int64) * points.shape[1]
    return arrays(tag, {"connectivity": points.reshape(-1).astype(np.int64), "offsets": ends})


def poly_data(positions, columns, lines, time):
    """Returns a file of points [N, 3] with columns by name, and lines [M, 2] between points; without lines each
    point is a vertex."""
    vertices = np.arange(len(positions))[:, None] if len(lines) == 0 else np.empty((0, 1))
    piece = f'NumberOfPoints="{len(positions)}" NumberOfVerts="{len(vertices)}" NumberOfLines="{len(lines)}"'
    return (
        HEAD.format("PolyData", DEFLATED)
        + f"<PolyData>\n{time_value(time)}<Piece {piece}>\n"
        + arrays("PointData", columns, Scalars="radius", Vectors="velocity")
        + f"<Points>\n{array('position', positions)}</Points>\n"
        + cells("Verts", vertices)
        + cells("Lines", np.asarray(lines).reshape(-1, 2))
        + "</Piece>\n</PolyData>\n</VTKFile>\n"
    )


def time_value(time):
    return "<FieldData>\n" + array("TimeValue", np.array([time]), ' NumberOfTuples="1"') + "</FieldData>\n"


def image_data(cell, values, name):
    """Returns a file of square cells with edges of this length from the origin on; each has one value of [ny, nx]."""
    rows, columns = values.shape
    extent = f"0 {columns} 0 {rows} 0 0"
    spacing = f"{cell:.17g} {cell:.17g} 1"
    return (
        HEAD.format("ImageData", DEFLATED)
        + f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{spacing}">\n<Piece Extent="{extent}">\n'
        + arrays("CellData", {name: values.reshape(-1)}, Scalars=name)
        + "</Piece>\n</ImageData>\n</VTKFile>\n"
    )


def collection(files):
    """Returns a file that lists files as [(time, file name)]."""
    listed = "".join(f'<DataSet timestep="{time:.17g}" part="0" file="{name}"/>\n' for time, name in files)
    return HEAD.format("Collection", "") + f"<Collection>\n{listed}</Collection>\n</VTKFile>\n"
