"""Self-tests of the validity decision.  Run: python3 test_validity.py."""
import unittest
from fractions import Fraction
from itertools import permutations

import numpy as np

import gmf
import jacobian

UNIT = np.vstack([np.zeros(3), np.eye(3)])


def tetrahedron(offsets):
    """Nodes of the unit tetrahedron with its 6 mid nodes moved by offsets."""
    mids = [UNIT[[a, b]].mean(axis=0) for a, b, _ in gmf.LOCAL_EDGES[3]]
    return np.vstack([UNIT, np.array(mids) + offsets])


def sampled_minimum(nodes, n=24):
    """Smallest det J of a P2 element on a lattice, from an independent implementation of the derivative."""
    k = nodes.shape[1]
    grid = np.indices((n + 1,) * k).reshape(k, -1).T
    grid = grid[grid.sum(axis=1) <= n] / n
    bary = np.column_stack([1 - grid.sum(axis=1), grid])
    jac = np.zeros((len(bary), k, k))
    for a in range(1, k + 1):
        for i in (0, a):
            sign = 1 if i else -1
            jac[:, :, a - 1] += sign * (4 * bary[:, i:i + 1] - 1) * nodes[i]
            for p, q, m in gmf.LOCAL_EDGES[k]:
                if i in (p, q):
                    other = q if i == p else p
                    jac[:, :, a - 1] += sign * 4 * bary[:, other:other + 1] * nodes[m]
    return np.linalg.det(jac).min()


def product_formula(nodes):
    """The 20 coefficients as means of 8 det(a_i, b_j, c_k) over ordered triples, as an alternative formula."""
    k = nodes.shape[1]
    control = {}
    for exps, node in zip(gmf.CANONICAL[k], nodes):
        on = [i for i in range(k + 1) if exps[i]]
        ends = [nodes[i] for i in on]
        control[exps] = node if len(on) == 1 else (4 * node - ends[0] - ends[1]) / 2
    unit = np.eye(k + 1, dtype=int)
    column = [[2 * (control[tuple(unit[i] + unit[a])] - control[tuple(unit[i] + unit[0])])
               for i in range(k + 1)] for a in range(1, k + 1)]
    out = []
    for alpha in jacobian.lattice(k):
        flat = [i for i in range(k + 1) for _ in range(alpha[i])]
        ways = set(permutations(flat))
        out.append(np.mean([np.linalg.det(np.column_stack([column[a][i] for a, i in enumerate(way)]))
                            for way in ways]))
    return np.array(out)


class Validity(unittest.TestCase):
    def verdict(self, nodes):
        float_verdict = jacobian.examine(nodes, np.arange(len(nodes))[None])["verdict"][0]
        self.assertEqual(float_verdict, jacobian.decide_exactly(nodes))
        return float_verdict

    def test_coefficients_agree_with_the_product_formula(self):
        random = np.random.default_rng(5)
        for count, k in ((10, 3), (6, 2)):
            nodes = random.normal(size=(50, count, k))
            mine, scale = jacobian.coefficients(nodes)
            for one, coefs, s in zip(nodes, mine, scale):
                np.testing.assert_allclose(coefs, product_formula(one), atol=1e-12)
                exact = jacobian.exact_coefficients(one)
                worst = max(abs(Fraction(float(c)) - e) for c, e in zip(coefs, exact))
                self.assertLess(worst, 64 * jacobian.EPS * s)

    def test_valid_and_clearly_invalid_tetrahedra_are_decided(self):
        bent = np.zeros((6, 3))
        bent[0] = [0, 0.1, 0.1]
        self.assertEqual(self.verdict(tetrahedron(bent)), jacobian.VALID)
        self.assertEqual(self.verdict(tetrahedron(5 * bent)), jacobian.INVALID)
        self.assertEqual(self.verdict(tetrahedron(bent * 0 + [0.6, 0, 0])), jacobian.INVALID)
        self.assertEqual(self.verdict(tetrahedron(bent)[[1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]),
                         jacobian.INVALID)

    def test_inconclusive_coefficients_are_decided_by_subdivision(self):
        random = np.random.default_rng(8)
        decided = {jacobian.VALID: 0, jacobian.INVALID: 0}
        while min(decided.values()) < 5:
            nodes = tetrahedron(random.normal(scale=0.16, size=(6, 3)))
            coefs = jacobian.coefficients(nodes[None])[0][0]
            if coefs[:4].min() <= 0 or coefs.min() > 0:
                continue  # corner values are positive, some coefficient is not
            low = sampled_minimum(nodes)
            if abs(low) < 0.02:
                continue
            expected = jacobian.VALID if low > 0 else jacobian.INVALID
            self.assertEqual(self.verdict(nodes), expected)
            decided[expected] += 1

    def test_verdicts_of_triangles_agree_with_sampling(self):
        random = np.random.default_rng(9)
        straight = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]])
        for _ in range(100):
            nodes = straight + random.normal(scale=0.15, size=(6, 2))
            low = sampled_minimum(nodes, 60)
            if abs(low) > 0.02:
                self.assertEqual(self.verdict(nodes), jacobian.VALID if low > 0 else jacobian.INVALID)

    def test_a_zero_determinant_at_a_vertex_is_invalid(self):
        """det J = 1 + 4 d.grad(xi_0 xi_1) with d = e_x / -4 is exactly 0 at vertex 0."""
        nodes = tetrahedron(np.zeros((6, 3)))
        nodes[4, 0] = 0.25
        self.assertEqual(self.verdict(nodes), jacobian.INVALID)
        nodes[4, 0] = np.nextafter(0.25, 1)
        self.assertEqual(self.verdict(nodes), jacobian.VALID)
        self.assertEqual(jacobian.examine(nodes, np.arange(10)[None])["decided_in_rationals"], 1)

    def test_thin_flat_and_non_finite_elements_are_decided(self):
        nodes = tetrahedron(np.zeros((6, 3)))
        turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        out = jacobian.examine(nodes * [1, 1, 1e-9] @ turn.T, np.arange(10)[None])
        self.assertEqual(out["verdict"][0], jacobian.VALID)
        self.assertEqual(jacobian.examine(nodes * [1, 1, 0], np.arange(10)[None])["straight_sign"][0], 0)
        self.assertEqual(jacobian.examine(nodes * [1, 1, -1], np.arange(10)[None])["straight_sign"][0], -1)
        self.assertEqual(jacobian.examine(nodes * [1, 1, np.nan], np.arange(10)[None])["verdict"][0],
                         jacobian.INVALID)

    def test_the_smallest_ratio_is_within_its_tolerance(self):
        random = np.random.default_rng(4)
        for _ in range(20):
            nodes = tetrahedron(random.normal(scale=0.1, size=(6, 3)))
            smallest = jacobian.examine(nodes, np.arange(10)[None])["smallest"]
            low = sampled_minimum(nodes, 40)
            self.assertLessEqual(smallest.lower, low + 1e-12)
            self.assertLessEqual(smallest.upper - smallest.lower, 1e-3)
            self.assertLess(low - smallest.upper, 0.02)


if __name__ == "__main__":
    unittest.main()
