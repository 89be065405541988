module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>
module camber.drawing:subdivision;
import camber.core;
import :drawn_face;

/// A patch as small flat triangles.
namespace camber {

/// How far a chord may be from its curve (pixels), and into how many pieces an edge goes at most.
constexpr double chord_error = 0.05;
constexpr std::size_t most_pieces = 64;

/// A power of two, so that the points of one number of pieces are points of a larger one. An edge whose middle is d
/// from that of its chord is d/n² from n chords.
inline std::size_t pieces_of_edge(const DrawnFace& patch, std::size_t edge) {
    const Vec<3> chord = midpoint(patch.nodes[edge], patch.nodes[(edge + 1) % 3]);
    const double wanted = std::sqrt(distance(patch.nodes[3 + edge], chord) / chord_error);
    std::size_t n = 1;
    while (n < most_pieces && static_cast<double>(n) < wanted) n *= 2;
    return n;
}

/// A point of the subdivision: where it is on the patch, and on paper.
struct SmallCorner {
    FacePoint xi;
    Vec<3> point;
};

/// The points of a patch cut into n pieces an edge. Those of an edge that needs fewer lie on its chords, where its
/// other patch has them too: no gap opens between the two.
class Subdivision {
  public:
    void cut(const DrawnFace& patch) {
        std::array<std::size_t, 3> pieces{};
        n_ = 1;
        for (std::size_t e = 0; e < 3; ++e) {
            pieces[e] = pieces_of_edge(patch, e);
            n_ = std::max(n_, pieces[e]);
        }
        corners_.clear();
        for (std::size_t j = 0; j <= n_; ++j)
            for (std::size_t i = 0; i + j <= n_; ++i) {
                const std::array<std::size_t, 3> lattice{n_ - i - j, i, j};
                FacePoint xi{};
                for (std::size_t k = 0; k < 3; ++k) xi[k] = static_cast<double>(lattice[k]) / static_cast<double>(n_);
                corners_.push_back({xi, on_paper(patch, pieces, lattice, xi)});
            }
    }
    /// visit(a, b, c) for each small triangle, turned as the patch is.
    template <class Visit>
    void each_triangle(Visit&& visit) const {
        for (std::size_t j = 0; j < n_; ++j)
            for (std::size_t i = 0; i + j < n_; ++i) {
                visit(at(i, j), at(i + 1, j), at(i, j + 1));
                if (i + j + 1 < n_) visit(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
    }

  private:
    [[nodiscard]] const SmallCorner& at(std::size_t i, std::size_t j) const {
        // Row j has n + 1 − j points.
        return corners_[j * (n_ + 1) - (j * j - j) / 2 + i];
    }
    [[nodiscard]] Vec<3> on_paper(const DrawnFace& patch, const std::array<std::size_t, 3>& pieces,
                                  const std::array<std::size_t, 3>& lattice, const FacePoint& xi) const {
        for (std::size_t e = 0; e < 3; ++e) {
            if (lattice[(e + 2) % 3] != 0 || pieces[e] == n_) continue;
            const std::size_t stride = n_ / pieces[e], along = lattice[(e + 1) % 3];
            const std::size_t before = along / stride * stride;
            if (before == along) break;
            const double t = static_cast<double>(along - before) / static_cast<double>(stride);
            return (1 - t) * on_edge(patch, e, before) + t * on_edge(patch, e, before + stride);
        }
        return point_at(patch.nodes, xi);
    }
    [[nodiscard]] Vec<3> on_edge(const DrawnFace& patch, std::size_t edge, std::size_t along) const {
        FacePoint xi{};
        xi[(edge + 1) % 3] = static_cast<double>(along) / static_cast<double>(n_);
        xi[edge] = 1 - xi[(edge + 1) % 3];
        return point_at(patch.nodes, xi);
    }

    std::size_t n_ = 1;
    std::vector<SmallCorner> corners_;
};

}  // namespace camber
