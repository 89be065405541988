module;
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.repair:nodewise;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.programmes;
import :relax;

namespace camber {

/// The nodes of a mesh while `relax` works on them, and what is known of its elements.
template <int D>
struct Repair {
    const QuadraticMesh<D>& mesh;  ///< with the proposal's points
    const Incidence<ElementId>& shells;
    Column<EdgeKind> kinds;
    RelaxOptions options;
    Buffer<LagrangeNode<D>> nodes;
    Buffer<Verdict> verdicts;
    std::map<EdgeId, LagrangeNode<D>> originals;  ///< of the nodes that moved, where they were at first

    [[nodiscard]] bool valid(ElementId e) const { return verdicts[e.index()] == Verdict::valid; }
    [[nodiscard]] LagrangeNode<D> middle(EdgeId edge) const {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const { return nodal_element<D>(mesh, nodes, e); }
    [[nodiscard]] bool straight(EdgeId edge) const { return nodes[edge.index()] == middle(edge); }
    /// M + θ (P^l − M), which is P_11 ← θ P_11 + (1 − θ) M (paper §3.2) in Lagrange form.
    [[nodiscard]] LagrangeNode<D> towards_middle(EdgeId edge, double theta) const;
    [[nodiscard]] double length(EdgeId edge) const;
};

/// Which edges a step may move.
enum class EdgeGroup { volume, surface, all };
[[nodiscard]] bool contains(EdgeGroup group, EdgeKind kind);

/// The edges of an element that are of the group and not straight yet.
template <int D>
[[nodiscard]] std::vector<EdgeId> loose_edges(const Repair<D>& repair, ElementId e, EdgeGroup group);

/// What changes did, to take them back.
template <int D>
struct Changes {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;
    std::vector<std::pair<ElementId, Verdict>> verdicts;
    std::vector<ElementId> broken;  ///< elements that were valid and are not any more
};

/// Moves one node without a look at its elements.
template <int D>
void move_node(Repair<D>& repair, EdgeId edge, const LagrangeNode<D>& node, Changes<D>& changes);

/// Verdicts of the elements around these edges.
template <int D>
void check_shells(Repair<D>& repair, std::span<const EdgeId> edges, Changes<D>& changes);

/// Takes all changes back.
template <int D>
void undo(Repair<D>& repair, const Changes<D>& changes);

/// Jacobian of an element with one of its nodes elsewhere.
template <int D>
[[nodiscard]] BoundedJacobian<D> jacobian_with(const Repair<D>& repair, ElementId e, EdgeId edge,
                                               const LagrangeNode<D>& node);

/// One node of an element at a time, each by a linear programme over its shell: the one that mends the element at the
/// least loss (to the target; failing that, to the bound; failing that, one that only helps, each if allowed), until
/// the element is valid or nothing helps. True if any node moved.
enum class Steps { to_target, to_bound, helping };
template <int D>
bool mend(Repair<D>& repair, ElementId e, EdgeGroup group, Steps steps);

/// Plain θ-steps on an element and on those that break by it, kept only if all of them reach this scaled Jacobian in
/// the end and not too many were drawn in.
template <int D>
bool mend_with_neighbours(Repair<D>& repair, ElementId e, EdgeGroup group, double scaled_jacobian);

/// Moves a node back to where it was at first, as far as its shell allows. True if it moved.
template <int D>
bool put_back(Repair<D>& repair, EdgeId edge);

}  // namespace camber
