#!/usr/bin/env python3
"""Advection and diffusion with GetFEM on a curved mesh of triangles of degree 2: a front along a curved stream.

    solve.py MESH.mesh SOLUTION.sol [WIDTH]

    -ε div grad u + b · grad u = f in the domain, u = g on its boundary:
    ∫ ε grad u · grad v + (b · grad u) v dx = ∫ f v dx   for all v that are 0 on the boundary,

with the exact solution u = tanh(s / WIDTH), s = y - y0(x), y0 = 0.55 + 0.15 cos(2π(x - 1.5) / 3), and b = (1, y0') along its
lines of equal u, so that f = -ε div grad u. ε is 0.01. WIDTH is 0.05; with 1 meshes of any size resolve it, and errors show the
order of convergence, h^3 in L2. The front's elements are so thin across the stream that nothing has to be stabilised.
"""
import os
import sys

import getfem
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from mesh_files import read_mesh, write_solution  # noqa: E402

WIDTH = float(sys.argv[3]) if len(sys.argv) > 3 else 0.05
DIFFUSION = 0.01

# GetFEM's language: X is the place. u = tanh(s / w), |grad s|² = 1 + y0'², div grad s = -y0''.
ANGLE = "(2*pi*(X(1)-1.5)/3)"
FRONT = f"(0.55+0.15*cos({ANGLE}))"
SLOPE = f"(-0.1*pi*sin({ANGLE}))"
BEND = f"(-pi*pi/15*cos({ANGLE}))"
EXACT = f"tanh((X(2)-{FRONT})/w)"
LAPLACIAN = f"((1-sqr({EXACT}))/w*(-2*{EXACT}/w*(1+sqr({SLOPE}))-({BEND})))"
GRADIENT = f"((1-sqr({EXACT}))/w*[-{SLOPE}; 1])"


def exact(x, y):
    return np.tanh((y - (0.55 + 0.15 * np.cos(2 * np.pi * (x - 1.5) / 3))) / WIDTH)


def make(triangles):
    """GetFEM's mesh of curved triangles, its finite elements, and for each triangle the numbers of its nodes in the file, in
    GetFEM's order: by rows of the triangle, (0,0) (½,0) (1,0) (0,½) (½,½) (0,1)."""
    order = [0, 3, 1, 5, 4, 2]
    domain = getfem.Mesh("empty", 2)
    nodes = triangles.elements[:, order]
    domain.add_convex(getfem.GeoTrans("GT_PK(2,2)"), triangles.nodes[nodes].transpose(2, 1, 0))
    elements = getfem.MeshFem(domain, 1)
    elements.set_fem(getfem.Fem("FEM_PK(2,2)"))
    return domain, elements, nodes


def solve(domain, elements):
    wall = 1
    domain.set_region(wall, domain.outer_faces())
    rule = getfem.MeshIm(domain, getfem.Integ("IM_TRIANGLE(8)"))
    x, y = elements.basic_dof_nodes()
    model = getfem.Model("real")
    model.add_fem_variable("u", elements)
    model.add_initialized_data("w", WIDTH)
    model.add_initialized_data("eps", DIFFUSION)
    model.add_initialized_fem_data("g", elements, exact(x, y))
    model.add_linear_term(rule, f"eps*Grad_u.Grad_Test_u + ([1; {SLOPE}].Grad_u)*Test_u")
    model.add_source_term(rule, f"-eps*{LAPLACIAN}*Test_u")
    model.add_Dirichlet_condition_with_simplification("u", wall, "g")
    model.solve()

    def norm(integrand):
        return np.sqrt(getfem.asm_generic(rule, 0, integrand, -1, model))

    return model.variable("u"), (norm(f"sqr(u-{EXACT})"), norm(f"Norm_sqr(Grad_u-{GRADIENT})"))


def main():
    triangles = read_mesh(sys.argv[1])
    domain, elements, nodes = make(triangles)
    u, errors = solve(domain, elements)

    # GetFEM numbers nodes anew; those of u in a triangle are in the order of the triangle's own.
    values = np.empty(len(triangles.nodes))
    dofs, begins = elements.basic_dof_from_cvid()
    values[nodes.ravel()] = u[dofs.ravel()]
    write_solution(sys.argv[2], 2, values)
    print("unknowns %d, elements %d, error in L2 %.3e, in H1 %.3e" % (len(values), len(nodes), *errors))


if __name__ == "__main__":
    main()
