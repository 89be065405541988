module;
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>
export module camber.repair:options;
import camber.core;
import camber.validity;

export namespace camber {

/// How nodes find a place at which the elements around them are valid.
enum class RepairMethod : std::uint8_t {
    /// Towards the boundary's displacement extended, by as few halvings as the elements need, the last step exactly
    /// there; what that leaves as by `cavity`. Then nodes return towards where they are wanted.
    extension,
    /// By programmes over cavities, nearest to where nodes are wanted: several nodes together; then one; then the
    /// boundary's displacement extended; then larger cavities, vertices and, last, surface nodes.
    cavity,
    edge,  ///< by programmes of one volume node at a time alone
    /// Node by node, as little as needed: each moves on the segment to the middle of its chord to the farthest place
    /// where the elements of its shell hold, by a linear programme; steps by theta only for what that cannot repair;
    /// nodes are put back as far as they may at the end.
    segment,
    /// The paper's (§3.2): P_11 ← θ P_11 + (1 − θ) M for all volume edges of an element that is not valid, then for its
    /// surface edges, until it is; elements that break by it are next.
    theta,
};
[[nodiscard]] constexpr auto words(RepairMethod) {
    return words_of(Word{RepairMethod::extension, "extension"}, Word{RepairMethod::cavity, "cavity"},
                    Word{RepairMethod::edge, "edge"}, Word{RepairMethod::segment, "segment"},
                    Word{RepairMethod::theta, "relax"});
}

/// Whether a method ends with cavities, which may move vertices and surface nodes.
[[nodiscard]] constexpr bool has_cavities(RepairMethod method) {
    return method == RepairMethod::extension || method == RepairMethod::cavity;
}

/// Whether a method weighs places by models, one an edge; the others take none.
[[nodiscard]] constexpr bool needs_models(RepairMethod method) {
    return has_cavities(method) || method == RepairMethod::edge;
}

enum class VertexMoves : std::uint8_t { allowed, never };
[[nodiscard]] constexpr auto words(VertexMoves) {
    return words_of(Word{VertexMoves::allowed, "move"}, Word{VertexMoves::never, "keep"});
}

/// What is asked of the elements, and what may be done for it.
struct RepairOptions {
    JacobianBound min_scaled_jacobian = {};
    double target = default_bound;
    RepairMethod method = RepairMethod::extension;
    double boundary_tolerance = 0;
    VertexMoves vertices = VertexMoves::allowed;
    /// A step of a programme with ten unknown points counts 1, others with the square of their number. So repair ends
    /// where what is asked cannot be had; counts, not seconds, so that the result is the same on any machine.
    double effort = 500;
    double return_effort = 0.05;  ///< the same, of the programmes by which nodes return where they went home
    double theta = 0.75;
    int max_corrections = 40;
    double max_work = std::numeric_limits<double>::infinity();  ///< what may be spent in all, beside `effort`

    /// What repaired elements are to reach where they can.
    [[nodiscard]] constexpr double aim() const {
        return target > min_scaled_jacobian ? target : min_scaled_jacobian.value;
    }

    [[nodiscard]] static constexpr auto options() {
        using S = RepairOptions;
        return std::tuple(
            option("repair", &S::method,
                   "extension: the nodes of an element that is not good enough go back towards the boundary's "
                   "displacement extended, then as near to their places as they may; what is left as by cavity; "
                   "cavity: the nodes of an element together, else one edge, then larger cavities, then vertices; "
                   "edge: one node at a time, nearest to where it is wanted; segment: the same towards the middle of "
                   "the chord, each as little as its elements need; relax: each edge of an invalid element by theta, "
                   "as in the paper"),
            option("target", &S::target,
                   "what is aimed at in repaired elements where it can be had, as a share of the straight element's "
                   "determinant: the bound, where that is more")
                .at_least(0)
                .below(1),
            option("boundary_tolerance", &S::boundary_tolerance,
                   "of a mesh that was read with its curves: how far the node of a boundary edge may move where "
                   "nothing else helps; 0: the boundary stays as it is. After curve, such nodes may always go back to "
                   "their chords")
                .unit("model units")
                .at_least(0),
            option("vertices", &S::vertices,
                   "move: vertices go where nodes alone do not repair an element, those of the boundary along a "
                   "prescribed geometry; keep: all stay. Required ones and corners never move"),
            option(
                "effort", &S::effort,
                "work that cavity and edge may spend for each element that is not good enough, in steps of "
                "programmes of ten nodes; easily repaired ones leave theirs to others, and what is not repaired when "
                "it is spent is listed")
                .at_least(0),
            option("return_effort", &S::return_effort,
                   "by extension: work that programmes may spend, for each element that was not good enough, to bring "
                   "nodes nearer to their places, beside that of a hundred such programmes; 1 or more wins back a "
                   "little more")
                .at_least(0),
            option("theta", &S::theta, "what a correction leaves of a node's offset")
                .unit("shares of the offset")
                .above(0)
                .below(1),
            option("max_corrections", &S::max_corrections, "corrections before a node goes to the middle of its chord")
                .at_least(1)
                .at_most(10000),
            bound_option<S>());
    }
    friend bool operator==(const RepairOptions&, const RepairOptions&) = default;
};

/// The work that a repair of so many elements that are not good enough may take: effort · (200 + elements). Where there
/// are few, one may take more.
[[nodiscard]] constexpr double allowed_work(std::size_t elements, double effort) {
    return (200 + static_cast<double>(elements)) * effort;
}

/// What of it may be spent on returns of nodes that went home: 100 + return_effort · elements.
[[nodiscard]] constexpr double allowed_return_work(std::size_t elements, const RepairOptions& options) {
    return 100 + static_cast<double>(elements) * options.return_effort;
}

}  // namespace camber
