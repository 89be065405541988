module;
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.repair:trial;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import :moved_mesh;
import :options;

namespace camber {

/// A mesh while nodes move on the segments to the middles of their chords.
template <int D>
struct SegmentState {
    MovedMesh<D> moved;
    const Incidence<ElementId>& shells;
    const Column<EdgeKind>& kinds;
    const RepairOptions& options;
};

/// What a piece of work tries on it, seen as the mesh that it would become.
template <int D>
struct Trial {
    const SegmentState<D>& state;
    SparseMap<EdgeId, LagrangeNode<D>> nodes = {};
    SparseMap<ElementId, Verdict> verdicts = {};

    [[nodiscard]] const QuadraticMesh<D>& mesh() const { return state.moved.mesh; }
    [[nodiscard]] const LagrangeNode<D>& node(EdgeId edge) const {
        const auto* tried = nodes.find(edge);
        return tried ? *tried : state.moved.nodes[edge];
    }
    [[nodiscard]] Verdict verdict(ElementId e) const {
        const auto* tried = verdicts.find(e);
        return tried ? *tried : state.moved.verdicts[e];
    }
    [[nodiscard]] bool valid(ElementId e) const { return verdict(e) == Verdict::valid; }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> s = state.moved.element(e);
        if (!nodes.empty())
            for (int i = 0; i < edges_per_simplex<D>; ++i)
                s.nodes[D + 1 + i] = node(mesh().edges.of_elements[e][i]).point;
        return s;
    }
    [[nodiscard]] LagrangeNode<D> middle(EdgeId edge) const { return state.moved.middle(edge); }
    [[nodiscard]] bool straight(EdgeId edge) const { return node(edge) == middle(edge); }
    /// M + θ (P^l − M), which is P_11 ← θ P_11 + (1 − θ) M (paper §3.2) in Lagrange form.
    [[nodiscard]] LagrangeNode<D> towards_middle(EdgeId edge, double theta) const;
    [[nodiscard]] double length(EdgeId edge) const;
    /// What it came to.
    [[nodiscard]] Moves<D> moves() const;
};

/// Which edges a step may move.
enum class EdgeGroup { volume, surface, all };
[[nodiscard]] bool contains(EdgeGroup group, EdgeKind kind);

/// The edges of an element that are of the group and not straight yet.
template <int D>
[[nodiscard]] std::vector<EdgeId> loose_edges(const Trial<D>& trial, ElementId e, EdgeGroup group);

/// What changes did, to take them back.
template <int D>
struct Changes {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;
    std::vector<std::pair<ElementId, Verdict>> verdicts;
    std::vector<ElementId> broken;  ///< elements that were valid and are not any more
};

/// Moves one node without a look at its elements.
template <int D>
void move_node(Trial<D>& trial, EdgeId edge, const LagrangeNode<D>& node, Changes<D>& changes);

/// Verdicts of the elements around these edges.
template <int D>
void check_shells(Trial<D>& trial, std::span<const EdgeId> edges, Changes<D>& changes);

/// Takes all changes back.
template <int D>
void undo(Trial<D>& trial, const Changes<D>& changes);

/// Jacobian of an element with one of its nodes elsewhere.
template <int D>
[[nodiscard]] BoundedJacobian<D> jacobian_with(const Trial<D>& trial, ElementId e, EdgeId edge,
                                               const LagrangeNode<D>& node);

/// One node of an element at a time, each by a linear programme over its shell: the one that repairs the element at the
/// least loss (to the target; failing that, to the bound; failing that, one that only helps, each if allowed), until
/// the element is valid or nothing helps. True if any node moved.
enum class Steps { to_target, to_bound, helping };
template <int D>
bool repair_element(Trial<D>& trial, ElementId e, EdgeGroup group, Steps steps);

/// Plain θ-steps on an element and on those that break by it, kept only if all of them reach this scaled Jacobian in
/// the end and not too many were drawn in.
template <int D>
bool repair_with_neighbours(Trial<D>& trial, ElementId e, EdgeGroup group, double scaled_jacobian);

/// Moves a node back to where it was at first, as far as its shell allows. True if it moved.
template <int D>
bool put_back(Trial<D>& trial, EdgeId edge);

}  // namespace camber
