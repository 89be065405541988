module;
#include <array>
#include <limits>
#include <optional>
#include <utility>
export module camber.optimisation:edge_programme;
import camber.core;
import camber.bezier;
import camber.validity;
import :edge_shell;
import :linear_programme;
import :quadratic_programme;

export namespace camber {

/// How far the programmes of one edge go where the coefficient test is too weak: there an element is bisected, and the
/// coefficients of its parts, affine in the node as well, take the place of its own.
struct EdgeProgrammeOptions {
    double tolerance = 1e-3;  ///< cuts end when the optimum is known to this, relative to max(1, |optimum|)
    int max_cuts = 60;        ///< bisections in all; 0: the plain coefficient test
    /// Cuts end when the largest smallest value is known to be above or below this.
    double enough = std::numeric_limits<double>::infinity();
    /// Without cuts: no node is returned unless its coefficients exceed this, which costs less to detect.
    double least = -std::numeric_limits<double>::infinity();
};

/// A point P and M directions in which the node may move: all of them in the volume (M = D), the tangents of a surface
/// or of a ridge.
template <int D, int M>
struct TangentSpace {
    Vec<D> point;
    std::array<Vec<D>, M> tangents{};  ///< orthonormal

    [[nodiscard]] constexpr Vec<D> at(const Vec<M>& y) const {
        Vec<D> p = point;
        for (int i = 0; i < M; ++i) p += y[i] * tangents[i];
        return p;
    }
};

/// The place of the edge's node that makes the smallest scaled Jacobian of the shell largest.
template <int D>
struct HighestNode {
    LagrangeNode<D> node;
    /// Certified: det J / |det straight| is nowhere less in the elements that `keep` nothing, with this node.
    double lower = 0;
    /// No node reaches more, but for rounding (without cuts: none by its coefficients); ∞ if `enough` was there at
    /// once.
    double upper = 0;
    int cuts = 0;  ///< bisections made
};

/// The valid node nearest to a target position.
template <int D>
struct NearestNode {
    LagrangeNode<D> node;
    double cost = 0;  ///< of the model there
    int cuts = 0;
};

/// Can this edge alone repair its shell? The node with the largest smallest value of det J / |det straight| in the
/// elements without `keep`, while the others stay above theirs: a linear programme in D unknowns and the bound, then
/// cuts until `lower` and `upper` agree to the tolerance or tell which side of `enough` they are on. None if the
/// elements that `keep` something cannot, or no element is to be raised.
template <int D>
[[nodiscard]] std::optional<HighestNode<D>> highest_node(const EdgeShell<D>& shell,
                                                         const EdgeProgrammeOptions& options = {});

/// The node of the least model value among those with which every element is valid by `decide`: above `bound`, or above
/// what it `keep`s. A quadratic programme, then cuts where coefficients that are no values of det J hold it back. None
/// if there is no such node, or none was found with the cuts allowed.
template <int D>
[[nodiscard]] std::optional<NearestNode<D>> nearest_node(const EdgeShell<D>& shell, const QuadraticModel<D>& model,
                                                         double bound, const EdgeProgrammeOptions& options = {});

/// The highest node in a tangent space. `reach`: largest change of the coefficients (see highest_point).
template <int D, int M>
[[nodiscard]] std::optional<HighestNode<D>> highest_node_in(const EdgeShell<D>& shell, const TangentSpace<D, M>& space,
                                                            double reach, const EdgeProgrammeOptions& options);

/// Whether all elements of the shell are valid by `decide` with this node: above `bound`, or above what they `keep`.
template <int D>
[[nodiscard]] bool holds(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double bound);

/// Certified lower bound of det J / |det straight| in the elements that `keep` nothing: the coefficients', or `enough`,
/// where these do; within scaled_jacobian_tolerance of the minimum elsewhere.
template <int D>
[[nodiscard]] double smallest_scaled_jacobian(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double enough);

}  // namespace camber
