"""Files written by meshio, for sample_of_files.py."""
try:
    import meshio
except ImportError:
    meshio = None

SIMPLICES = {"triangle": 2, "triangle6": 2, "tetra": 3, "tetra10": 3}
# Extension, options of the writer, True if it supports cells of degree 2.
WAYS = [("vtu", {"binary": False}, True), ("vtu", {"compression": None}, True), ("vtu", {"compression": "zlib"}, True),
        ("vtu", {"compression": "lzma"}, True), ("vtk", {"file_format": "vtk42", "binary": False}, True),
        ("vtk", {"file_format": "vtk42"}, True), ("vtk", {"file_format": "vtk51", "binary": False}, True),
        ("vtk", {"file_format": "vtk51"}, True), ("msh", {"file_format": "gmsh22", "binary": False}, True),
        ("msh", {"file_format": "gmsh22"}, True), ("msh", {"file_format": "gmsh", "binary": False}, True),
        ("msh", {"file_format": "gmsh"}, True), ("mesh", {"file_format": "medit"}, False), ("meshb", {"file_format": "medit"}, False),
        ("su2", {"file_format": "su2"}, False)]


def counts(path):
    """Returns simplices of the highest dimension, or None if there are other cells or meshio cannot read the file."""
    if meshio is None:
        return None
    numbers = {}
    for cells in meshio.read(path).cells:
        if cells.type in ("vertex", "line", "line3"):
            continue
        if cells.type not in SIMPLICES:
            return None
        numbers[SIMPLICES[cells.type]] = numbers.get(SIMPLICES[cells.type], 0) + len(cells.data)
    return numbers[max(numbers)] if numbers else None


def triangles(path):
    """Returns the number of triangles, or None if meshio cannot read the file."""
    return None if meshio is None else sum(len(cells.data) for cells in meshio.read(path).cells if cells.type == "triangle")


def stl(folder, reference):
    """Writes the triangles of a mesh of degree 1, in binary and as text."""
    mesh = meshio.read(reference)
    rows = [cells.data for cells in mesh.cells if cells.type == "triangle"]
    for binary in (True, False):
        path = folder / f"meshio-{reference.stem}-{'binary' if binary else 'text'}.stl"
        meshio.Mesh(mesh.points, [("triangle", row) for row in rows]).write(path, binary=binary)
        yield "meshio stl", path, triangles(reference)


def files(folder, references):
    if meshio is None:
        return
    for reference in references:
        mesh = meshio.read(reference)
        expected = counts(reference)
        quadratic = any(cells.type in ("triangle6", "tetra10") for cells in mesh.cells)
        for number, (ending, options, knows_quadratic) in enumerate(WAYS):
            if quadratic and not knows_quadratic:
                continue
            path = folder / f"meshio-{reference.stem}-{number}.{ending}"
            try:
                meshio.read(reference).write(path, **options)
            except Exception as error:  # files that meshio cannot write are not in the sample
                print(f"meshio does not write {path.name}: {error}")
                continue
            yield "meshio " + ending, path, expected
        if not quadratic:
            yield from stl(folder, reference)
