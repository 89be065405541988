"""Reader of text files of Gmsh (versions 2.2 and 4.1) that shares no code with Camber."""
from collections import Counter
from dataclasses import dataclass, field

NODES = {15: 1, 1: 2, 8: 3, 2: 3, 9: 6, 4: 4, 11: 10}
DIMENSION = {15: 0, 1: 1, 8: 1, 2: 2, 9: 2, 4: 3, 11: 3}


@dataclass
class Msh:
    nodes: dict = field(default_factory=dict)    # tag: (x, y, z)
    places: dict = field(default_factory=dict)   # tag: (dimension, entity, parameters)
    elements: list = field(default_factory=list)  # (tag, type, entity, physical tags, node tags)
    names: dict = field(default_factory=dict)    # (dimension, physical tag): name

    def cells(self, types=None):
        """Number of elements by type, entity, groups and node coordinates."""
        return Counter((kind, entity, physicals, tuple(rounded(self.nodes[n]) for n in nodes))
                       for _, kind, entity, physicals, nodes in self.elements if not types or kind in types)


def rounded(point):
    """Rounds a point, since Gmsh writes 16 digits."""
    return tuple(round(x, 9) + 0.0 for x in point)


def sections(text):
    lines = text.split("\n")
    at = 0
    while at < len(lines):
        if lines[at].startswith("$"):
            end = lines.index("$End" + lines[at][1:].strip(), at)
            yield lines[at][1:].strip(), lines[at + 1:end]
            at = end
        at += 1


def read(path):
    msh = Msh()
    physicals = {}
    version = None
    for name, lines in sections(path.read_text()):
        if name == "MeshFormat":
            version = lines[0].split()[0]
            assert lines[0].split()[1:] == ["0", "8"], lines[0]
        elif name == "PhysicalNames":
            for line in lines[1:]:
                dimension, tag, text = line.split(" ", 2)
                msh.names[int(dimension), int(tag)] = text.strip()[1:-1]
        elif name == "Entities":
            physicals = entities(lines)
        elif name == "Nodes" and version == "4.1":
            nodes_4(msh, lines)
        elif name == "Elements" and version == "4.1":
            elements_4(msh, lines, physicals)
        elif name == "Nodes":
            for line in lines[1:]:
                tag, *point = line.split()
                msh.nodes[int(tag)] = tuple(map(float, point))
        elif name == "Elements":
            elements_2(msh, lines)
    return msh


def entities(lines):
    """Physical tags by dimension and entity."""
    physicals = {}
    counts = list(map(int, lines[0].split()))
    rows = iter(lines[1:])
    for dimension, count in enumerate(counts):
        for _ in range(count):
            words = next(rows).split()
            at = 4 if dimension == 0 else 7
            n = int(words[at])
            physicals[dimension, int(words[0])] = tuple(sorted(abs(int(w)) for w in words[at + 1:at + 1 + n]))
    return physicals


def nodes_4(msh, lines):
    blocks, total, _, _ = map(int, lines[0].split())
    at = 1
    for _ in range(blocks):
        dimension, entity, parametric, n = map(int, lines[at].split())
        tags = [int(line) for line in lines[at + 1:at + 1 + n]]
        for tag, line in zip(tags, lines[at + 1 + n:at + 1 + 2 * n]):
            values = tuple(map(float, line.split()))
            assert len(values) == 3 + (dimension if parametric else 0)
            msh.nodes[tag] = values[:3]
            msh.places[tag] = (dimension, entity, values[3:])
        at += 1 + 2 * n
    assert len(msh.nodes) == total


def elements_4(msh, lines, physicals):
    blocks, total, _, _ = map(int, lines[0].split())
    at = 1
    for _ in range(blocks):
        dimension, entity, kind, n = map(int, lines[at].split())
        assert DIMENSION[kind] == dimension
        for line in lines[at + 1:at + 1 + n]:
            tag, *nodes = map(int, line.split())
            assert len(nodes) == NODES[kind]
            msh.elements.append((tag, kind, entity, physicals[dimension, entity], tuple(nodes)))
        at += 1 + n
    assert len(msh.elements) == total


def elements_2(msh, lines):
    for line in lines[1:]:
        tag, kind, n, *rest = map(int, line.split())
        assert len(rest) == n + NODES[kind]
        msh.elements.append((tag, kind, rest[1], (rest[0],), tuple(rest[n:])))
    assert len(msh.elements) == int(lines[0])
