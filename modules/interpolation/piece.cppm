module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.interpolation:piece;
import camber.core;
import camber.bezier;
import :collapsed_rule;
import :error;

namespace camber {

/// A quadratic over a simplex: the linear function through its corners, and at each edge's middle what it has beyond
/// that. What is straight then stays so to rounding.
template <int D, class T>
struct Quadratic {
    std::array<T, D + 1> corners{};
    std::array<T, edges_per_simplex<D>> bubbles{};

    [[nodiscard]] T at(const Barycentric<D>& xi) const {
        T value{};
        for (int i = 0; i <= D; ++i) value = value + corners[i] * xi[i];
        for (int e = 0; e < edges_per_simplex<D>; ++e) value = value + bubbles[e] * edge_shape<D>(xi, e);
        return value;
    }
};

/// An element, or a part of it by a straight cut of the reference simplex, with the interpolants whose errors are
/// asked for.
template <int D>
struct Piece {
    Vec<D> origin;                ///< places are relative to it, so that small elements far from 0 keep their digits
    Quadratic<D, Vec<D>> places;  ///< F
    bool straight = false;        ///< F is affine
    int interpolants = 1;
    std::array<Quadratic<D, double>, 2> values{};  ///< u_h ∘ F
    double rounding = 0;  ///< of a value of u: its evaluation's, and that of the places where it is evaluated
};

/// Integrals over a piece. Of each interpolant: ∫ e², ∫ |∇e|², each with the share that rounding may have.
struct Integrals {
    static constexpr int quantities = 4;       ///< L2 and H1 of two interpolants
    std::array<double, quantities> squares{};  ///< L2, H1, L2, H1
    double l2_rounding = 0, h1_rounding = 0;
    bool turned = false;  ///< det J <= 0 at a point

    Integrals& operator+=(const Integrals& other);
};

/// What integrating needs beside the rule: arrays of one value a point, used again from piece to piece.
template <int D>
class Integrator {
  public:
    explicit Integrator(PointFunction<D> field) : field_(std::move(field)) {}

    [[nodiscard]] Integrals integrate(const Piece<D>& piece, const CollapsedRule<D>& rule);
    /// u at points.
    void evaluate(std::span<const Vec<D>> points, std::span<double> values) { field_(points, values); }
    /// The points of the last piece, with u at them.
    [[nodiscard]] std::span<const Vec<D>> points() const { return points_; }
    [[nodiscard]] std::span<const double> values() const { return values_; }

  private:
    void resize(std::size_t count);
    void place(const Piece<D>& piece, const CollapsedRule<D>& rule);
    void subtract(const Quadratic<D, double>& interpolant, const CollapsedRule<D>& rule, std::vector<double>& error);

    PointFunction<D> field_;
    std::vector<Vec<D>> points_;
    std::array<std::array<std::vector<double>, D>, D> columns_;  ///< of J
    std::vector<double> values_, error_, other_error_;
    std::array<std::vector<double>, D> slopes_;  ///< of the first interpolant's error, by ξ
};

/// Which nodes: the middles of the chords, or those of the mesh.
enum class Sides : std::uint8_t { straight, curved };

template <int D>
[[nodiscard]] std::array<Vec<D>, quadratic_nodes<D>> nodes_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides);

/// An element's places and values: of straight elements with the interpolants of degree 2 and 1, of curved ones with
/// that of degree 2; or, where there are values at the mesh's nodes, with the function of degree 2 that has these.
template <int D>
[[nodiscard]] Piece<D> piece_of(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, std::span<const double> nodal,
                                Integrator<D>& integrator);

/// 2^D pieces that together are the piece.
template <int D>
[[nodiscard]] std::array<Piece<D>, (1U << D)> divided(const Piece<D>& piece);

}  // namespace camber
