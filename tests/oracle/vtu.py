"""Reader of VTK UnstructuredGrid files (.vtu, appended raw data, zlib blocks) for the oracle.

It shares no code with the library.  Format: VTK's description of its XML files; the XML in front of the data is
parsed as such, the data behind the underscore as bytes.
"""
import xml.etree.ElementTree as ElementTree
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

TYPES = {"Float64": "f8", "Float32": "f4", "Int64": "i8", "Int32": "i4", "UInt8": "u1", "UInt64": "u8"}
# cell type -> (dimension, degree); both families of degree 2 have the nodes e01 e12 e20 e03 e13 e23 last
CELLS = {3: (1, 1), 5: (2, 1), 10: (3, 1), 21: (1, 2), 22: (2, 2), 24: (3, 2), 68: (1, 2), 69: (2, 2), 71: (3, 2)}


class VtuError(Exception):
    """The file breaks the format."""


@dataclass
class Vtu:
    points: np.ndarray        # n x 3
    cells: list               # node numbers of each cell
    types: np.ndarray
    point_data: dict          # name -> array, one row a point
    cell_data: dict
    components: dict          # name -> names of the components


def demand(condition, message):
    if not condition:
        raise VtuError(message)


def blocks(data, at, order):
    """The bytes of one array: UInt64 header of blocks, block size, last partial size, compressed sizes."""
    count, size, last = np.frombuffer(data, order + "u8", 3, at)
    sizes = np.frombuffer(data, order + "u8", int(count), at + 24)
    at += 24 + 8 * int(count)
    out = []
    for k, packed in enumerate(sizes):
        out.append(zlib.decompress(data[at:at + int(packed)]))
        at += int(packed)
        expected = int(last) if k + 1 == count and last else int(size)
        demand(len(out[-1]) == expected, f"block {k} has {len(out[-1])} bytes, not {expected}")
    return b"".join(out), at


def read(path):
    data = Path(path).read_bytes()
    mark = b'<AppendedData encoding="raw">\n_'
    head = data.index(mark)
    begin = head + len(mark)
    tail = data[data.rindex(b"\n</AppendedData>"):]
    root = ElementTree.fromstring(data[:head] + b'<AppendedData encoding="raw">' + tail)
    demand(root.get("type") == "UnstructuredGrid" and root.get("header_type") == "UInt64", "another kind of file")
    demand(root.get("compressor") == "vtkZLibDataCompressor", "another compressor")
    order = {"LittleEndian": "<", "BigEndian": ">"}[root.get("byte_order")]
    piece = root.find("UnstructuredGrid/Piece")
    ends, names = [], {}

    def array(tag):
        width = int(tag.get("NumberOfComponents", 1))
        raw, end = blocks(data, begin + int(tag.get("offset")), order)
        ends.append((int(tag.get("offset")), end - begin))
        names[tag.get("Name")] = [tag.get(f"ComponentName{i}") for i in range(width)]
        values = np.frombuffer(raw, order + TYPES[tag.get("type")])
        return values.reshape(-1, width) if width > 1 else values

    def data_of(where):
        tags = piece.find(where)
        demand(len({t.get("Name") for t in tags}) == len(tags), f"{where}: a name twice")
        return {t.get("Name"): array(t) for t in tags}

    point_data, cell_data = data_of("PointData"), data_of("CellData")
    points = array(piece.find("Points/DataArray"))
    topology = data_of("Cells")
    count, cells = int(piece.get("NumberOfPoints")), int(piece.get("NumberOfCells"))
    demand(points.shape == (count, 3), "the points are not as many as announced")
    offsets, types = topology["offsets"], topology["types"]
    demand(len(offsets) == len(types) == cells, "the cells are not as many as announced")
    demand(sorted(ends) == ends and all(a[1] == b[0] for a, b in zip(ends, ends[1:])), "gaps between the arrays")
    demand(ends[-1][1] == data.rindex(b"\n</AppendedData>") - begin, "bytes behind the last array")
    for values, rows in [(v, count) for v in point_data.values()] + [(v, cells) for v in cell_data.values()]:
        demand(len(values) == rows, "a field has another number of rows")
    rows = np.split(topology["connectivity"], offsets[:-1]) if cells else []
    for row, kind in zip(rows, types):
        dimension, degree = CELLS[int(kind)]
        nodes = dimension + 1 if degree == 1 else (dimension + 1) * (dimension + 2) // 2
        demand(len(row) == nodes and (row < count).all(), "a cell with wrong nodes")
    return Vtu(points, rows, types, point_data, cell_data, names)
