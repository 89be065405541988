// A mesh with moved nodes and vertices, trials of relaxation, local extension.
module;
#include <array>
#include <span>
#include <utility>
#include <vector>
module camber.repair:moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import :options;

namespace camber {

/// What is to change in a mesh.
template <int D>
struct Moves {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;  ///< rising
    std::vector<std::pair<VertexId, Vec<D>>> points;        ///< rising
    std::vector<std::pair<ElementId, Verdict>> verdicts;    ///< of the elements that these touch
};

/// A mesh with some points and nodes elsewhere, and its elements' verdicts there: what every way of repair looks at.
/// Its cost goes with what is elsewhere, so that trying something on a copy is cheap.
template <int D>
struct MovedMesh {
    const QuadraticMesh<D>& mesh;  ///< topology, and where vertices were; its nodes are not looked at
    Overlay<VertexId, Vec<D>> points;
    Overlay<EdgeId, LagrangeNode<D>> nodes;
    Overlay<ElementId, Verdict> verdicts;

    explicit MovedMesh(const JudgedProposal<D>& judged)
        : mesh(judged.mesh()),
          points(judged.proposal().points),
          nodes(judged.proposal().mid_nodes),
          verdicts(judged.validation().verdicts) {}

    [[nodiscard]] bool is_valid(ElementId e) const { return verdicts[e] == Verdict::valid; }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> s;
        for (int i = 0; i <= D; ++i) s.nodes[i] = points[mesh.linear.elements.vertices[e][i]];
        for (int i = 0; i < edges_per_simplex<D>; ++i) s.nodes[D + 1 + i] = nodes[mesh.edges.of_elements[e][i]].point;
        return s;
    }
    /// The same with one of its nodes elsewhere.
    [[nodiscard]] NodalSimplex<D> element_with(ElementId e, EdgeId edge, const LagrangeNode<D>& node) const {
        NodalSimplex<D> s = element(e);
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (mesh.edges.of_elements[e][i] == edge) s.nodes[D + 1 + i] = node.point;
        return s;
    }
    /// How far a vertex is from where the mesh has it.
    [[nodiscard]] Vec<D> shift(VertexId v) const { return points[v] - mesh.linear.points[v]; }
    /// How far that takes the middle of an edge.
    [[nodiscard]] Vec<D> shift(EdgeId edge) const {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return 0.5 * (shift(a) + shift(b));
    }
    [[nodiscard]] LagrangeNode<D> middle(EdgeId edge) const {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return {midpoint(points[a], points[b])};
    }
    void apply(const Moves<D>& moves) {
        for (const auto& [edge, node] : moves.nodes) nodes.set(edge, node);
        for (const auto& [vertex, point] : moves.points) points.set(vertex, point);
        for (const auto& [element, verdict] : moves.verdicts) verdicts.set(element, verdict);
    }
    /// All that is elsewhere.
    [[nodiscard]] Moves<D> moves() const {
        Moves<D> all;
        for (const EdgeId edge : nodes.set_rows()) all.nodes.emplace_back(edge, nodes[edge]);
        for (const VertexId vertex : points.set_rows()) all.points.emplace_back(vertex, points[vertex]);
        for (const ElementId e : verdicts.set_rows()) all.verdicts.emplace_back(e, verdicts[e]);
        return all;
    }
    /// Its places as a proposal for the mesh, with the kinds of the one that it began with.
    [[nodiscard]] Proposal<D> proposal(const Proposal<D>& before) const {
        Proposal<D> after{points.column(), nodes.column(), before.kinds, {}};
        after.changes = changes_after(mesh, before, after.points, after.mid_nodes);
        return after;
    }
};

/// Its places, judged where they are others than in `before`: all of them where vertices moved. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<JudgedProposal<D>> judge_moved(const MovedMesh<D>& moved, const Incidence<ElementId>& shells,
                                                     const JudgedProposal<D>& before, const Execution& execution);

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

/// Nodes of edges, and the work that it took to find them, in the units of `RepairOptions::effort`.
template <int D>
struct LocalExtension {
    SparseMap<EdgeId, LagrangeNode<D>> nodes;
    double work = 0;
};

/// The boundary's displacement extended (`extend_boundary`) around some elements alone: nodes of the volume edges of
/// the `seeds` and of so many rings of elements around them, while all nodes around these are given where they are.
/// Its cost goes with these elements. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<LocalExtension<D>> extend_around(const MovedMesh<D>& moved, const Column<EdgeKind>& kinds,
                                                       const Incidence<ElementId>& shells,
                                                       const std::vector<ElementId>& seeds, int rings,
                                                       const Execution& execution);

/// Volume nodes around elements that are not valid, and nodes of the boundary's plane pieces within their planes by at
/// most the tolerance, go where a linear extension of all other boundary nodes' displacements has them, as far out as
/// that breaks elements. The boundary's shape stays. The proposal need not be better. Errors: stopped.
[[nodiscard]] Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance,
                                                  const Execution& execution);

}  // namespace camber
