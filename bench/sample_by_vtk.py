"""Files written by VTK, for sample_of_files.py."""
try:
    import vtk
except ImportError:
    vtk = None

ARRAYS = ("reference", "Material", "RegionId", "attribute")


def grid(n, array, quadratic=False):
    """Returns a box of n³ cells cut into tetrahedra, with its bottom facets; integer cell data, scalar and vector point data."""
    source = vtk.vtkUniformGrid()
    source.SetDimensions(n + 1, n + 1, n + 1)
    cut = vtk.vtkDataSetTriangleFilter()
    cut.SetInputData(source)
    cut.Update()
    cut_mesh = vtk.vtkUnstructuredGrid()
    cut_mesh.SetPoints(cut.GetOutput().GetPoints())
    corners = [cut.GetOutput().GetCell(c).GetPointIds() for c in range(cut.GetOutput().GetNumberOfCells())]
    cells = [[ids.GetId(k) for k in range(4)] for ids in (cut.GetOutput().GetCell(c).GetPointIds() for c in range(len(corners)))]
    if quadratic:
        mid, points = {}, cut_mesh.GetPoints()

        def node(a, b):
            key = (min(a, b), max(a, b))
            if key not in mid:
                p, q = points.GetPoint(a), points.GetPoint(b)
                mid[key] = points.InsertNextPoint([(x + y) / 2 for x, y in zip(p, q)])
            return mid[key]
        cells = [[*c, *(node(c[a], c[b]) for a, b in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)))] for c in cells]
    for cell in cells:
        cut_mesh.InsertNextCell(24 if quadratic else 10, len(cell), cell)
    whole, real, flow = vtk.vtkIntArray(), vtk.vtkDoubleArray(), vtk.vtkFloatArray()
    whole.SetName(array)
    real.SetName("T")
    flow.SetName("U")
    flow.SetNumberOfComponents(3)
    for c in range(len(cells)):
        whole.InsertNextValue(1 + c % 3)
    for p in range(cut_mesh.GetNumberOfPoints()):
        real.InsertNextValue(0.1 * p)
        flow.InsertNextTuple3(p, 1, 0)
    cut_mesh.GetCellData().AddArray(whole)
    cut_mesh.GetPointData().AddArray(real)
    cut_mesh.GetPointData().AddArray(flow)
    return cut_mesh, len(cells)


def pieces(folder):
    """Writes pieces of one file as in a parallel run, without and with cells of their neighbours."""
    for number, ghosts in ((2, 0), (3, 0), (3, 1)):
        cut_mesh, cells = grid(3, "RegionId")
        cut = vtk.vtkExtractUnstructuredGridPiece()
        cut.SetInputData(cut_mesh)
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetInputConnection(cut.GetOutputPort())
        writer.SetNumberOfPieces(number)
        writer.SetGhostLevel(ghosts)
        path = folder / f"vtk-pieces-{number}-{ghosts}.vtu"
        writer.SetFileName(str(path))
        writer.Write()
        yield "VTK .vtu", path, cells


def stl(folder):
    """Writes a sphere of triangles, in binary and as text."""
    for binary in (True, False):
        source = vtk.vtkSphereSource()
        source.SetThetaResolution(24)
        source.SetPhiResolution(12)
        source.Update()
        writer = vtk.vtkSTLWriter()
        writer.SetInputData(source.GetOutput())
        writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
        path = folder / f"vtk-{'binary' if binary else 'text'}.stl"
        writer.SetFileName(str(path))
        writer.Write()
        yield "VTK .stl", path, source.GetOutput().GetNumberOfPolys()


def files(folder):
    if vtk is None:
        return
    number = 0
    for compress in ("None", "ZLib", "LZ4", "LZMA"):
        for mode in ("Ascii", "Binary", "Appended"):
            for big in (False, True):
                cut_mesh, cells = grid(2, ARRAYS[number % len(ARRAYS)], number % 2 == 1)
                writer = vtk.vtkXMLUnstructuredGridWriter()
                writer.SetInputData(cut_mesh)
                getattr(writer, "SetCompressorTypeTo" + compress)()
                getattr(writer, "SetDataModeTo" + mode)()
                writer.SetByteOrderToBigEndian() if big else writer.SetByteOrderToLittleEndian()
                writer.SetHeaderTypeToUInt64() if number % 3 == 0 else writer.SetHeaderTypeToUInt32()
                writer.SetEncodeAppendedData(number % 2 == 0)
                path = folder / f"vtk-{compress}-{mode}-{'big' if big else 'little'}.vtu"
                writer.SetFileName(str(path))
                writer.Write()
                yield "VTK .vtu", path, cells
                number += 1
    for version in (42, 51):
        for quadratic in (False, True):
            for array in ARRAYS:
                cut_mesh, cells = grid(2, array, quadratic)
                writer = vtk.vtkUnstructuredGridWriter()
                writer.SetInputData(cut_mesh)
                writer.SetFileVersion(version)
                writer.SetFileTypeToBinary() if array in ARRAYS[:2] else writer.SetFileTypeToASCII()
                path = folder / f"vtk-{version}-{quadratic}-{array}.vtk"
                writer.SetFileName(str(path))
                writer.Write()
                yield "VTK .vtk", path, cells
    yield from pieces(folder)
    yield from stl(folder)
