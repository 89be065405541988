module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.metric:element_frame;
import camber.core;

namespace camber {

template <int D>
using Barycentrics = std::array<double, D + 1>;

/// The barycentric coordinates of an element as functions: u_i(x) with Σ u_i = 1 and u_i(vertex j) = δ_ij.
template <int D>
struct Frame {
    std::array<Vec<D>, D + 1> p;         ///< the corners
    std::array<Vec<D>, D + 1> gradient;  ///< ∇u_i; they sum to zero
    int base = 0;                        ///< the vertex that points are measured from
    double determinant = 0;              ///< ± D! times the volume
    double condition_squared = 0;        ///< of what multiplies rounding errors in u

    Frame(const LinearMesh<D>& mesh, ElementId e) {
        const auto& v = mesh.elements.vertices[e];
        for (int i = 0; i <= D; ++i) p[i] = mesh.points[v[i]];
        Mat<D> sides;
        double lengths_squared = 1;
        for (int i = 0; i < D; ++i) {
            sides.column[i] = p[i + 1] - p[0];
            lengths_squared *= norm_squared(sides.column[i]);
        }
        const auto cofactor = cofactors(sides);
        determinant = dot(cofactor[0], sides.column[0]);
        condition_squared = lengths_squared / (determinant * determinant);
        if (!(condition_squared < 1e8)) {
            measure_slim();
            return;
        }
        const double scale = 1 / determinant;
        gradient[0] = {};
        for (int i = 0; i < D; ++i) {
            gradient[i + 1] = scale * cofactor[i];
            gradient[0] -= gradient[i + 1];
        }
    }

    [[nodiscard]] Barycentrics<D> barycentrics(const Vec<D>& x) const {
        Barycentrics<D> u{};
        const Vec<D> r = x - p[base];
        double rest = 1;
        for (int i = 0; i <= D; ++i) {
            if (i == base) continue;
            u[i] = dot(gradient[i], r);
            rest -= u[i];
        }
        u[base] = rest;
        return u;
    }
    /// Points this near outside of the element (barycentric) count as in it: what rounding may do to the coordinates of
    /// a point of the element, so that a point on a face is in one of its two elements at least.
    [[nodiscard]] double tolerance() const {
        return condition_squared < 1e4 ? 1e-12 : std::min(1e-14 * std::sqrt(condition_squared), 1e-4);
    }

  private:
    /// The sides of a needle are all but parallel, and their cross products rounding errors. So the longest side's part
    /// is taken off the others first (a shear, which keeps the determinant): what is left is the needle's thickness, to
    /// the digits that the coordinates have.
    void measure_slim() {
        const auto [from, to] = longest_side();
        base = from;
        std::array<int, D> order{to};
        for (int i = 0, n = 1; i <= D && n < D; ++i)
            if (i != from && i != to) order[n++] = i;
        const Vec<D> along = p[to] - p[from];
        Mat<D> sides;
        sides.column[0] = along;
        std::array<double, D> part{};
        for (int k = 1; k < D; ++k) {
            const Vec<D> side = p[order[k]] - p[from];
            part[k] = dot(side, along) / norm_squared(along);
            sides.column[k] = side - part[k] * along;
        }
        const auto cofactor = cofactors(sides);
        determinant = dot(cofactor[0], along);
        const double scale = 1 / determinant;
        for (int k = 0; k < D; ++k) gradient[order[k]] = scale * cofactor[k];
        for (int k = 1; k < D; ++k) gradient[to] -= part[k] * gradient[order[k]];
        gradient[from] = {};
        double steepest = 0;
        for (int k = 0; k < D; ++k) {
            gradient[from] -= gradient[order[k]];
            steepest = std::max(steepest, norm_squared(gradient[order[k]]));
        }
        condition_squared = steepest * norm_squared(along);
    }
    [[nodiscard]] std::array<int, 2> longest_side() const {
        std::array<int, 2> best{0, 1};
        double longest = 0;
        for (int i = 0; i <= D; ++i)
            for (int j = i + 1; j <= D; ++j)
                if (const double l = norm_squared(p[j] - p[i]); l > longest) {
                    longest = l;
                    best = {i, j};
                }
        return best;
    }
};

/// The corners of a face of an element.
template <int D>
std::array<Vec<D>, D> face_points(const LinearMesh<D>& mesh, const ElementFace& face) {
    std::array<Vec<D>, D> p;
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    for (int i = 0; i < D; ++i) p[i] = mesh.points[mesh.elements.vertices[face.element][local[i]]];
    return p;
}

}  // namespace camber
