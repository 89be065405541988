"""Parts for bench/curvature.py, made by Gmsh: NAME.step, the straight mesh NAME.msh, and two meshes of degree 2 with the same vertices, by setOrder(2) only
(NAME-gmsh-0.msh) and with its optimiser as in HighOrderOptimize 2 (NAME-gmsh-2.msh). Needs the Python module of Gmsh: python3-gmsh."""
import math
import multiprocessing
import os


def bend(occ):
    """A quarter of a torus, solid."""
    occ.revolve([(2, occ.addDisk(0, 0, 0, 10, 10))], 30, 0, 0, 0, 1, 0, math.pi / 2)
    return 3.2


def elbow(occ):
    """A pipe with a wall, swept along a leg, a bend, a leg."""
    corners = [occ.addPoint(*at) for at in ((0, 0, -20), (0, 0, 0), (30, 0, 30), (50, 0, 30))]
    centre = occ.addPoint(30, 0, 0)
    path = occ.addWire([occ.addLine(corners[0], corners[1]), occ.addCircleArc(corners[1], centre, corners[2]),
                        occ.addLine(corners[2], corners[3])])
    outer, inner = [(2, occ.addDisk(0, 0, -20, radius, radius)) for radius in (10, 6)]
    section, _ = occ.cut([outer], [inner])
    occ.addPipe(section, path)
    occ.remove(section, recursive=True)
    return 4


def block(occ):
    """A block with a bore."""
    occ.cut([(3, occ.addBox(-20, -15, 0, 40, 30, 20))], [(3, occ.addCylinder(0, 0, -1, 0, 0, 22, 8))])
    return 4


PARTS = {"bend": bend, "elbow": elbow, "block": block}


def groups(model):
    """Creates groups of plane faces, of other faces and of the volume."""
    faces = [tag for _, tag in model.getEntities(2)]
    planes = [tag for tag in faces if model.getType(2, tag) == "Plane"]
    for dim, tags in ((2, planes), (2, sorted(set(faces) - set(planes))), (3, [tag for _, tag in model.getEntities(3)])):
        model.addPhysicalGroup(dim, tags)


def make_here(part, folder):
    import gmsh
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # OpenCASCADE prints messages while it writes
    gmsh.initialize([], False)
    gmsh.option.setNumber("General.Terminal", 0)
    size = PARTS[part](gmsh.model.occ)
    for dim in (2, 1, 0):
        gmsh.model.occ.remove(gmsh.model.occ.getEntities(dim))  # those that bound nothing
    gmsh.model.occ.synchronize()
    gmsh.write(str(folder / f"{part}.step"))
    groups(gmsh.model)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(folder / f"{part}.msh"))
    gmsh.option.setNumber("Mesh.HighOrderOptimize", 0)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(str(folder / f"{part}-gmsh-0.msh"))
    for method in ("HighOrderElastic", "HighOrder"):
        gmsh.model.mesh.optimize(method)
    gmsh.write(str(folder / f"{part}-gmsh-2.msh"))


def make(part, folder):
    """Makes a part in a separate process, since Gmsh keeps its options."""
    process = multiprocessing.Process(target=make_here, args=(part, folder))
    process.start()
    process.join()
    if process.exitcode != 0:
        raise SystemExit(f"curvature_parts.py: Gmsh ended with {process.exitcode} at {part} (is python3-gmsh installed?)")
