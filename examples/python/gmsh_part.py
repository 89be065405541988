#!/usr/bin/env python3
"""A part that Gmsh makes and meshes in memory, curved onto its own CAD model."""
import os
import tempfile

import gmsh

import camber

with tempfile.TemporaryDirectory() as folder:
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    block = gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
    hole = gmsh.model.occ.addCylinder(1, 0.5, 0, 0, 0, 1, 0.3)
    gmsh.model.occ.cut([(3, block)], [(3, hole)])
    gmsh.model.occ.synchronize()
    solid = gmsh.model.addPhysicalGroup(3, [v for _, v in gmsh.model.getEntities(3)])
    gmsh.model.setPhysicalName(3, solid, "solid")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.25)
    gmsh.model.mesh.generate(3)
    mesh = camber.from_gmsh(gmsh.model)
    step = os.path.join(folder, "part.step")
    gmsh.write(step)
    gmsh.finalize()
    made = camber.curve(mesh, cad=step)

print(made.mesh)
print(camber.check(made)["table"])
