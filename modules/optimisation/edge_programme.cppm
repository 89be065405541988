module;
#include <array>
#include <concepts>
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
    /// Without cuts: a node is given only if by its coefficients it reaches more than this. None is cheaper to tell.
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

/// The node nearest to a wanted one.
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

/// The same two in a tangent space. The node is in it, not on the surface, and not judged by `decide`: see
/// `surface_node`. `reach`: by how much coefficients may change, at most (see highest_point).
template <int D, int M>
[[nodiscard]] std::optional<HighestNode<D>> highest_node_in(const EdgeShell<D>& shell, const TangentSpace<D, M>& space,
                                                            double reach, const EdgeProgrammeOptions& options);
template <int D, int M>
[[nodiscard]] std::optional<NearestNode<D>> nearest_node_in(const EdgeShell<D>& shell, const TangentSpace<D, M>& space,
                                                            const QuadraticModel<D>& model, double bound,
                                                            const EdgeProgrammeOptions& options);

/// Whether all elements of the shell are valid by `decide` with this node: above `bound`, or above what they `keep`.
template <int D>
[[nodiscard]] bool holds(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double bound);

/// Certified lower bound of det J / |det straight| in the elements that `keep` nothing: the coefficients', or `enough`,
/// where these do; within scaled_jacobian_tolerance of the minimum elsewhere.
template <int D>
[[nodiscard]] double smallest_scaled_jacobian(const EdgeShell<D>& shell, const LagrangeNode<D>& node, double enough);

/// Puts a point onto a surface or a ridge, and says how that lies there.
template <class F, int D, int M>
concept TangentProjection = requires(F f, Vec<D> p) {
    { f(p) } -> std::convertible_to<TangentSpace<D, M>>;
};

}  // namespace camber

namespace camber {

inline constexpr int max_surface_steps = 16;
inline constexpr double min_surface_step = 1.0 / 64;

/// What a place on a surface is worth: validity first, then the model's cost, or how far from valid it is.
template <int D, int M>
struct SurfacePlace {
    TangentSpace<D, M> space;
    bool valid = false;
    double cost = 0, smallest = 0;

    [[nodiscard]] bool better_than(const SurfacePlace& o, double tolerance) const {
        if (valid != o.valid) return valid;
        return valid ? cost < o.cost - tolerance * magnitude_of(o.cost) : smallest > o.smallest + tolerance;
    }
    [[nodiscard]] static constexpr double magnitude_of(double x) { return x < 0 ? -x : x; }
};

template <int D, int M>
[[nodiscard]] inline SurfacePlace<D, M> surface_place(const EdgeShell<D>& shell, const QuadraticModel<D>& model,
                                                      double bound, const TangentSpace<D, M>& space) {
    return {space, holds(shell, {space.point}, bound), model(space.point),
            smallest_scaled_jacobian(shell, {space.point}, bound)};
}

}  // namespace camber

export namespace camber {

/// nearest_node for a node that has to stay on a surface (M = 2 in 3D) or on a curve (M = 1): a sequence of programmes
/// in tangent spaces, each answer put back by `project`, shortened until it is better than where it started. While no
/// node in the tangent space is valid the smallest value is raised instead. The result is exactly as `project` gave it.
/// None if no valid place was met.
template <int D, int M, TangentProjection<D, M> Project>
[[nodiscard]] std::optional<NearestNode<D>> surface_node(const EdgeShell<D>& shell, const QuadraticModel<D>& model,
                                                         Project&& project, double bound,
                                                         const EdgeProgrammeOptions& options = {}) {
    const auto place = [&](const Vec<D>& p) { return surface_place<D, M>(shell, model, bound, project(p)); };
    auto here = place(shell.node.point);
    double margin = 0;
    for (int turn = 0; turn < max_surface_steps; ++turn) {
        std::optional<Vec<D>> wanted;
        if (const auto nearest = nearest_node_in(shell, here.space, model, bound + margin, options)) {
            wanted = nearest->node.point;
        } else if (!here.valid) {
            const double reach = 2 * (1 + SurfacePlace<D, M>::magnitude_of(here.smallest));
            if (const auto highest = highest_node_in(shell, here.space, reach, options)) wanted = highest->node.point;
        }
        if (!wanted) {
            if (margin == 0) break;
            margin = margin > 1e-6 ? margin / 4 : 0;
            continue;
        }
        auto there = place(*wanted);
        // The surface bends away from the tangent space, so that demands met there are missed here: ask for more. What
        // is missed vanishes with the step.
        const double missed = bound + margin - there.smallest;
        const bool useful = there.better_than(here, 1e-6) || !there.valid;
        for (double part = 0.5; part >= min_surface_step && !there.better_than(here, 1e-6); part /= 2)
            there = place(here.space.point + part * (*wanted - here.space.point));
        const bool moved = there.better_than(here, 1e-6);
        if (!moved && !useful) break;
        if (moved) here = there;
        margin = missed > 0 ? 1.1 * missed : 0;
    }
    if (!here.valid) return {};
    return NearestNode<D>{{here.space.point}, here.cost, 0};
}

}  // namespace camber
