#!/usr/bin/env python3
"""Poisson's equation with DOLFINx (0.5) on a curved mesh of degree 2, in 2D or 3D: a layer along the wall r = 1.

    solve.py MESH.msh SOLUTION.sol [WIDTH]

    -div grad u = f in the domain, u = g on its boundary:   ∫ grad u · grad v dx = ∫ f v dx   for all v that are 0 on the boundary,

f and g are of the exact solution u = exp(-(r - 1) / WIDTH), r the distance from the origin. WIDTH is 0.05; with 1 meshes of any
size resolve it, and errors show the order of convergence, h^3 in L2.
"""
import os
import sys

import gmsh
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.io import gmshio
from mpi4py import MPI

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from mesh_files import write_solution  # noqa: E402

WIDTH = float(sys.argv[3]) if len(sys.argv) > 3 else 0.05


def read(path):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    dimension = gmsh.model.getDimension()
    domain, _, _ = gmshio.model_to_mesh(gmsh.model, MPI.COMM_SELF, 0, gdim=dimension)
    gmsh.finalize()
    return domain


def solve(domain):
    dimension = domain.topology.dim
    x = ufl.SpatialCoordinate(domain)
    r = ufl.sqrt(ufl.dot(x, x))
    exact = ufl.exp(-(r - 1) / WIDTH)
    f = -exact * (1 / WIDTH**2 - (dimension - 1) / (WIDTH * r))  # -(u'' + (dimension - 1) u' / r)

    # Elements of degree 2 in x as in u. f is no polynomial: its integrals take a rule of a higher degree.
    space = fem.FunctionSpace(domain, ("Lagrange", 2))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    dx = ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": 8})

    domain.topology.create_connectivity(dimension - 1, dimension)
    facets = mesh.exterior_facet_indices(domain.topology)
    wall = fem.Function(space)
    wall.interpolate(lambda x: np.exp(-(np.linalg.norm(x, axis=0) - 1) / WIDTH))
    conditions = [fem.dirichletbc(wall, fem.locate_dofs_topological(space, dimension - 1, facets))]

    direct = {"ksp_type": "preonly", "pc_type": "lu"}
    multigrid = {"ksp_type": "cg", "pc_type": "gamg", "ksp_rtol": 1e-10}
    problem = fem.petsc.LinearProblem(ufl.inner(ufl.grad(u), ufl.grad(v)) * dx, f * v * dx, conditions,
                                      petsc_options=direct if dimension == 2 else multigrid)
    u = problem.solve()
    if problem.solver.getConvergedReason() < 0:
        sys.exit("the iteration did not converge")

    def norm(integrand):
        return np.sqrt(fem.assemble_scalar(fem.form(integrand * dx)))

    errors = norm((u - exact)**2), norm(ufl.inner(ufl.grad(u - exact), ufl.grad(u - exact)))
    return u, errors


def in_order_of_file(u):
    """DOLFINx numbers nodes anew. Nodes of u and of the geometry are the same, element by element; input_global_indices tells
    the place of a node of the geometry in the order of the file: for .msh that of its tags."""
    geometry, space = u.function_space.mesh.geometry, u.function_space
    place = np.array(geometry.input_global_indices)[geometry.dofmap.array]
    values = np.empty(len(geometry.x))
    values[place] = u.x.array[space.dofmap.list.array]
    return values


def main():
    domain = read(sys.argv[1])
    u, errors = solve(domain)
    values = in_order_of_file(u)
    write_solution(sys.argv[2], domain.topology.dim, values)
    elements = domain.topology.index_map(domain.topology.dim).size_local
    print("unknowns %d, elements %d, error in L2 %.3e, in H1 %.3e" % (len(values), elements, *errors))


if __name__ == "__main__":
    main()
