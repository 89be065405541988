"""Files in formats of programs that are not installed, for sample_of_files.py: (kind, name, simplices of the highest dimension, text).
None: the content does not fit into a mesh of Camber, or the format belongs to another program, which must be reported."""

POINTS = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
GMF = "Dimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 1\n"
SQUARE = "NELEM= 2\n5 0 1 2 0\n5 0 2 3 1\n"
MARKER = "NMARK= 1\nMARKER_TAG= wall\nMARKER_ELEMS= 4\n3 0 1\n3 1 2\n3 2 3\n3 3 0\n"
MFEM = "dimension\n2\n\nelements\n2\n1 2 0 1 2\n2 2 0 2 3\n\n%sboundary\n4\n1 1 0 1\n2 1 1 2\n2 1 2 3\n1 1 3 0\n\n%svertices\n4\n2\n0 0\n1 0\n1 1\n0 1\n%s"
MSH_2 = "$MeshFormat\n%s 0 8\n$EndMeshFormat\n%s$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n%s$EndElements\n%s"
TETRAHEDRON = "%d 4 2 1 1 1 2 3 4\n"


def gmf():
    tables = "Normals\n2\n0 0 -1\n0 0 -1\nNormalAtVertices\n2\n1 1\n2 2\n"
    yield "Mmg", "mmg.mesh", 1, "\nMeshVersionFormatted 2\n\n\n" + GMF + tables + "Tangents\n1\n1 0 0\nTangentAtVertices\n1\n1 1\n\nEnd\n"
    yield "Mmg", "mmg-tangents.mesh", 1, "MeshVersionFormatted 2\n" + GMF + tables + "Tangents\n1\n1 0 0\nTangentAtVertices\n1\n1 2\nEnd\n"
    yield "Mmg", "mmg-required.mesh", 1, "MeshVersionFormatted 2\n" + GMF + "RequiredVertices\n2\n1\n3\nCorners\n1\n4\nEnd\n"
    yield "Metris", "corners.mesh", 1, "MeshVersionFormatted 2\n" + GMF + "Corners\n3\n1\n0\n0\nEnd\n"
    yield "Bamg, FreeFEM", "bamg.mesh", 2, ('MeshVersionFormatted 0\n\nDimension\n2\n\nIdentifier\n"G=a.mesh;1, Date: 21/04/02 11:24 35s"\n\n'
                                            'Geometry\n"a.mesh"\n\nVertices\n4\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n\nEdges\n4\n1 2 1\n2 3 1\n3 4 2\n4 1 2\n\n'
                                            'Triangles\n2\n1 2 3 1\n1 3 4 1\n\nSubDomainFromMesh\n1\n3 1 1 1\n\nEnd\n')
    yield "Bamg, FreeFEM", "freefem.mesh", 2, ("MeshVersionFormatted 1\nDimension 2\nVertices\n4\n0 0 1\n1 0 1\n1 1 1\n0 1 1\nTriangles\n2\n1 2 3 1\n"
                                               "1 3 4 1\nEdges\n4\n1 2 1\n2 3 1\n3 4 2\n4 1 2\nEnd\n")
    yield "others' GMF", "no-version.mesh", 1, GMF + "End\n"
    yield "others' GMF", "no-end.mesh", 1, "MeshVersionFormatted 1\n" + GMF
    yield "others' GMF", "after-end.mesh", 1, "MeshVersionFormatted 1\n" + GMF + "End\nmade by hand\n"
    yield "others' GMF", "hexahedron.mesh", None, "MeshVersionFormatted 2\n" + GMF + "Hexahedra\n1\n1 2 3 4 1 2 3 4 0\nEnd\n"


def mfem():
    sets, walls = 'attribute_sets\n2\n"Left" 1 1\n"Both sides" 2 1 2\n\n', 'bdr_attribute_sets\n1\n"Wall" 2 1 2\n\n'
    yield "MFEM", "v10.mfem", 2, "MFEM mesh v1.0\n\n" + MFEM % ("", "", "")
    yield "MFEM", "v12.mesh", 2, "MFEM mesh v1.2\n\n" + MFEM % ("", "", "\nmfem_mesh_end\n")
    yield "MFEM", "v13.mesh", 2, "MFEM mesh v1.3\n\n" + MFEM % (sets, walls, "\nmfem_mesh_end\n")
    yield "MFEM", "quads.mesh", None, ("MFEM mesh v1.0\n\ndimension\n2\n\nelements\n1\n1 3 0 1 2 3\n\nboundary\n1\n1 1 0 1\n\nvertices\n4\n2\n"
                                       "0 0\n1 0\n1 1\n0 1\n")


def su2():
    points = {"plain": "NPOIN= 4\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n", "two-counts": "NPOIN= 4 4\n0 0 0 0\n1 0 1 1\n1 1 2 2\n0 1 3 3\n",
              "third": "NPOIN= 4\n0 0 0. 0\n1 0 0. 1\n1 1 0. 2\n0 1 0. 3\n", "bare": "NPOIN= 4\n0 0\n1 0\n1 1\n0 1\n"}
    for name, rows in points.items():
        yield "SU2", f"{name}.su2", 2, "NDIME= 2\n" + SQUARE + rows + MARKER
    yield "SU2", "no-end.su2", 2, ("NDIME= 2\n" + SQUARE + points["plain"] + MARKER)[:-1]
    zone = "NDIME= 2\n" + SQUARE + points["plain"] + MARKER
    yield "SU2", "zones.su2", 4, "NZONE= 2\nIZONE= 1\n" + zone + "IZONE= 2\n" + zone.replace("1 0 1\n", "-1 0 1\n").replace("1 1 2\n", "-1 1 2\n")
    yield "SU2", "quads.su2", None, "NDIME= 2\nNELEM= 1\n9 0 1 2 3 0\n" + points["plain"] + MARKER


def stl():
    facet = "facet normal %s\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 %s 0\n endloop\nendfacet\n"
    yield "others' STL", "unnamed.stl", 1, "solid\n" + facet % ("0 0 1", "1") + "endsolid\n"
    yield "others' STL", "upper.stl", 1, ("solid part\n" + facet % ("0 0 1", "1.0E+00") + "endsolid part\n").upper()
    yield "others' STL", "no-normals.stl", 1, "solid part\n" + facet % ("nan nan nan", "1") + "endsolid part"
    yield "others' STL", "solids.stl", 2, "solid a\n" + facet % ("0 0 1", "1") + "endsolid a\nsolid b\n" + facet % ("0 0 -1", "-1") + "endsolid b\n"
    yield "others' STL", "degenerate.stl", 1, "solid a\n" + facet % ("0 0 0", "0") + facet % ("0 0 1", "1") + "endsolid a\n"


def msh():
    names = '$PhysicalNames\n1\n1 "solid"\n$EndPhysicalNames\n'
    yield "others' MSH", "v20.msh", 1, MSH_2 % ("2", names, "1\n" + TETRAHEDRON % 1, "")
    yield "others' MSH", "degenerate.msh", 1, MSH_2 % ("2.2", "", "2\n1 1 2 0 1 1 1\n" + TETRAHEDRON % 2, "")
    yield "others' MSH", "after.msh", 1, MSH_2 % ("2.2", "", "1\n" + TETRAHEDRON % 1, "written by a script\n")
    yield "others' MSH", "stray.msh", 1, ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 2 2 0\n5 3 2 0\n$EndNodes\n"
                                          "$Elements\n2\n1 2 2 1 1 1 2 3\n2 1 2 7 7 4 5\n$EndElements\n")
    yield "others' MSH", "v1.msh", 1, ("$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n1\n1 4 1 1 4 1 2 3 4\n$ENDELM\n")
    yield "namesakes", "freefem.msh", None, "3 1 3\n0 0 1\n1 0 1\n0 1 2\n1 2 3 0\n1 2 1\n2 3 1\n3 1 2\n"
    yield "namesakes", "fluent.msh", None, '(0 "made by hand")\n(2 3)\n(10 (0 1 4 0 3))\n'
    yield "namesakes", "ansys.msh", None, "/COM,ANSYS RELEASE\n/PREP7\nNBLOCK,6,SOLID\n"


def files(folder):
    for kind, name, counts, text in (*gmf(), *mfem(), *su2(), *msh(), *stl()):
        path = folder / ("hand-" + name)
        path.write_text(text)
        yield kind, path, counts
