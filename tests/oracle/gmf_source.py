"""Walkers over the blocks of a GMF file, ASCII or binary, with one interface:
keyword(), integers(), count_and_value(), rows(), skip(), close_block()."""
from itertools import groupby

import numpy as np

END = "End"
SOLUTION = "SolAtVertices"

CODES = {3: "Dimension", 4: "Vertices", 5: "Edges", 6: "Triangles", 7: "Quadrilaterals",
         8: "Tetrahedra", 9: "Prisms", 10: "Hexahedra", 12: "RequiredTetrahedra", 13: "Corners", 14: "Ridges",
         15: "RequiredVertices", 16: "RequiredEdges", 17: "RequiredTriangles",
         20: "NormalAtVertices", 24: "TrianglesP2", 25: "EdgesP2", 30: "TetrahedraP2",
         40: "VerticesOnGeometricVertices", 41: "VerticesOnGeometricEdges",
         42: "VerticesOnGeometricTriangles", 49: "Pyramids", 54: END, 59: "Tangents",
         60: "Normals", 61: "TangentAtVertices", 62: SOLUTION, 125: "BezierBasis",
         127: "EdgesP2Ordering", 129: "TrianglesP2Ordering", 133: "TetrahedraP2Ordering"}


class GmfError(ValueError):
    """The file violates its format."""


class AsciiSource:
    """Walks the words of an ASCII file."""

    def __init__(self, data):
        lines = data.decode("ascii", "replace").splitlines()
        self.words = " ".join(line.split("#", 1)[0] for line in lines).split()
        if self.words[:1] != ["MeshVersionFormatted"]:
            raise GmfError("not a GMF file: no MeshVersionFormatted")
        self.version = int(self.words[1])
        self.at = 2

    def keyword(self):
        if self.at >= len(self.words):
            return END
        word = self.words[self.at]
        if not word[0].isalpha():
            raise GmfError(f"keyword expected, found '{word}': rows longer than their keyword says"
                           " (an order-2 mesh under degree-1 keywords?)")
        self.at += 1
        return word

    def integers(self, n, short=False):
        taken = [int(w) for w in self.words[self.at:self.at + n]]
        if len(taken) < n:
            raise GmfError("truncated file")
        self.at += n
        return taken

    count_and_value = integers

    def rows(self, pattern, n):
        words = self.words[self.at:self.at + n * len(pattern)]
        if len(words) < n * len(pattern):
            raise GmfError("truncated file")
        self.at += len(words)
        table = np.array(words, dtype=object).reshape(n, len(pattern))
        cols = np.array(list(pattern))
        return (table[:, cols == "i"].astype(np.int64), table[:, cols == "r"].astype(np.float64))

    def skip(self):
        while self.at < len(self.words) and not (
                self.words[self.at][0].isalpha()
                and self.words[self.at].lower() not in ("nan", "inf", "infinity")):
            self.at += 1

    def close_block(self, name):
        """Checks nothing: the next keyword() detects rows that are too long."""


class BinarySource:
    """Walks the blocks of a binary file."""

    def __init__(self, data):
        self.data = data
        first = int(np.frombuffer(data, "<i4", 1)[0])
        if first not in (1, 16777216):
            raise GmfError("not a binary GMF file: the first integer is not 1")
        order = "<" if first == 1 else ">"
        self.int32 = np.dtype(order + "i4")
        self.version = int(np.frombuffer(data, self.int32, 1, 4)[0])
        if self.version not in (1, 2, 3, 4):
            raise GmfError(f"GMF version {self.version} is not 1 to 4")
        self.real = np.dtype(order + ("f4" if self.version == 1 else "f8"))
        self.int = np.dtype(order + ("i8" if self.version == 4 else "i4"))
        self.position = np.dtype(order + ("i8" if self.version >= 3 else "i4"))
        self.at, self.next = 8, 8

    def take(self, dtype, n):
        if n < 0 or self.at + n * dtype.itemsize > len(self.data):
            raise GmfError("truncated file")
        out = np.frombuffer(self.data, dtype, n, self.at)
        self.at += n * dtype.itemsize
        return out

    def keyword(self):
        if self.at >= len(self.data):
            return END
        code = int(self.take(self.int32, 1)[0])
        name = CODES.get(code, f"keyword {code}")
        if name != END:
            start = self.at - 4
            self.next = int(self.take(self.position, 1)[0])
            if not start < self.next <= len(self.data):
                raise GmfError(f"{name}: the next block's position {self.next} is outside the file")
        return name

    def integers(self, n, short=False):
        return [int(i) for i in self.take(self.int32 if short else self.int, n)]

    def count_and_value(self, n):
        """The value of a keyword without a count: int32, or a number of the size of the block."""
        return self.integers(n, short=self.next - self.at == 4 * n)

    def rows(self, pattern, n):
        groups = [(kind, len(list(run))) for kind, run in groupby(pattern)]
        dtype = np.dtype([(kind, self.int if kind == "i" else self.real, (width,))
                          for kind, width in groups])
        table = self.take(dtype, n)
        empty = np.empty((n, 0))
        return (table["i"].astype(np.int64) if "i" in pattern else empty.astype(np.int64),
                table["r"].astype(np.float64) if "r" in pattern else empty)

    def skip(self):
        self.at = self.next

    def close_block(self, name):
        if self.at != self.next:
            raise GmfError(f"{name}: its rows end at byte {self.at}, the next block is at "
                           f"{self.next} (an order-2 mesh under degree-1 keywords?)")
