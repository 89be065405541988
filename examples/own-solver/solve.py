#!/usr/bin/env python3
"""Poisson's equation with isoparametric elements of degree 2 in numpy and scipy, on triangles or tetrahedra.

    solve.py MESH SOLUTION [WIDTH]     MESH: .mesh (GMF) or .mfem (MFEM); SOLUTION: .sol

    -div grad u = f in the domain, u = g on its boundary:   ∫ grad u · grad v dx = ∫ f v dx   for all v that are 0 on the boundary,

f and g are of the exact solution u = tanh((|x - c| - 1) / WIDTH): a front on a circle (a sphere) around c = (2.5, 0, 0).
WIDTH is 0.05; with 1 meshes of any size resolve it, and errors show the order of convergence, h^3 in L2.
"""
import os
import sys

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from mesh_files import EDGES, read_mesh, write_solution  # noqa: E402

CENTRE, RADIUS = np.array([2.5, 0.0, 0.0]), 1.0
WIDTH = float(sys.argv[3]) if len(sys.argv) > 3 else 0.05


def exact(x):
    """u and grad u at points (n, dimension)."""
    away = x - CENTRE[:x.shape[1]]
    r = np.linalg.norm(away, axis=1)
    u = np.tanh((r - RADIUS) / WIDTH)
    return u, ((1 - u * u) / WIDTH / r)[:, None] * away


def source(x):
    """f = -u'' - (dimension - 1) u' / r, of u as a function of r = |x - c|."""
    r = np.linalg.norm(x - CENTRE[:x.shape[1]], axis=1)
    u = np.tanh((r - RADIUS) / WIDTH)
    first = (1 - u * u) / WIDTH
    second = -2 * u * first / WIDTH
    return -second - (x.shape[1] - 1) * first / r


def quadrature(dimension, count):
    """Points of the reference simplex and weights: Gauss' points of the cube, collapsed."""
    points, weights = np.polynomial.legendre.leggauss(count)
    points, weights = (points + 1) / 2, weights / 2
    grids = np.meshgrid(*[points] * dimension, indexing="ij")
    weight = np.prod(np.meshgrid(*[weights] * dimension, indexing="ij"), axis=0).ravel()
    x, left = [], 1.0
    for axis, s in enumerate(grid.ravel() for grid in grids):
        x.append(left * s)
        weight = weight * (1 - s) ** (dimension - 1 - axis)
        left = left * (1 - s)
    return np.array(x).T, weight


def shape_functions(point):
    """The nodal functions of degree 2 at a point of the reference simplex, and their derivatives (nodes, dimension)."""
    dimension = len(point)
    l = np.concatenate(([1 - point.sum()], point))  # barycentric coordinates
    dl = np.vstack((-np.ones(dimension), np.eye(dimension)))
    edges = EDGES[dimension]
    values = [l[i] * (2 * l[i] - 1) for i in range(dimension + 1)] + [4 * l[i] * l[j] for i, j in edges]
    derivatives = [(4 * l[i] - 1) * dl[i] for i in range(dimension + 1)] + [4 * (l[i] * dl[j] + l[j] * dl[i]) for i, j in edges]
    return np.array(values), np.array(derivatives)


def at_points(mesh, count):
    """At each point of the rule: x, weight · det J, shape functions, their gradients in space, for all elements at once."""
    nodes = mesh.nodes[mesh.elements]
    for point, weight in zip(*quadrature(mesh.dimension, count)):
        values, derivatives = shape_functions(point)
        jacobian = nodes.transpose(0, 2, 1) @ derivatives  # dx_i / dξ_j
        gradients = derivatives @ np.linalg.inv(jacobian)
        yield values @ nodes, weight * np.abs(np.linalg.det(jacobian)), values, gradients


def solve(mesh):
    unknowns, per_element = len(mesh.nodes), mesh.elements.shape[1]
    stiffness, load = np.zeros((len(mesh.elements), per_element, per_element)), np.zeros((len(mesh.elements), per_element))
    for x, dx, values, gradients in at_points(mesh, 5 if mesh.dimension == 2 else 4):
        stiffness += (dx[:, None, None] * gradients) @ gradients.transpose(0, 2, 1)
        load += (dx * source(x))[:, None] * values
    rows = np.repeat(mesh.elements, per_element, axis=1).ravel()
    columns = np.tile(mesh.elements, (1, per_element)).ravel()
    matrix = scipy.sparse.csr_matrix((stiffness.ravel(), (rows, columns)), shape=(unknowns, unknowns))
    right = np.bincount(mesh.elements.ravel(), load.ravel(), unknowns)

    u, free = np.zeros(unknowns), np.ones(unknowns, dtype=bool)
    boundary = mesh.boundary_nodes()
    u[boundary], free[boundary] = exact(mesh.nodes[boundary])[0], False
    right = (right - matrix @ u)[free]
    matrix = matrix[free][:, free]
    if mesh.dimension == 2:
        u[free] = scipy.sparse.linalg.spsolve(matrix.tocsc(), right)
    else:
        diagonal = scipy.sparse.diags(1 / matrix.diagonal())
        u[free], left = scipy.sparse.linalg.cg(matrix, right, tol=1e-10, maxiter=20000, M=diagonal)
        if left:
            sys.exit("the iteration did not converge")
    return u


def errors(mesh, u):
    """Of the solution: ‖u - u_h‖ in L2, and of the gradient."""
    l2 = h1 = 0.0
    for x, dx, values, gradients in at_points(mesh, 7 if mesh.dimension == 2 else 5):
        value, gradient = exact(x)
        l2 += np.sum(dx * (value - u[mesh.elements] @ values) ** 2)
        h1 += np.sum(dx * np.sum((gradient - np.einsum("en,eni->ei", u[mesh.elements], gradients)) ** 2, axis=1))
    return np.sqrt(l2), np.sqrt(h1)


def main():
    mesh = read_mesh(sys.argv[1])
    u = solve(mesh)
    write_solution(sys.argv[2], mesh.dimension, u)
    print("unknowns %d, elements %d, error in L2 %.3e, in H1 %.3e" % (len(u), len(mesh.elements), *errors(mesh, u)))


if __name__ == "__main__":
    main()
