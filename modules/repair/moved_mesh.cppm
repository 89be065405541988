// A mesh with moved nodes and vertices, tentative moves, and local extension.
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

template <int D>
struct Moves {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;  ///< ascending
    std::vector<std::pair<VertexId, Vec<D>>> points;        ///< ascending
    std::vector<std::pair<ElementId, Verdict>> verdicts;    ///< verdicts of the elements around moved nodes and points
};

/// A mesh with moved points and nodes, and its verdicts. The cost of a copy depends only on the number of changes.
template <int D>
struct MovedMesh {
    const QuadraticMesh<D>& mesh;  ///< topology and original vertices; its nodes are not used
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
    [[nodiscard]] NodalSimplex<D> element_with(ElementId e, EdgeId edge, const LagrangeNode<D>& node) const {
        NodalSimplex<D> s = element(e);
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (mesh.edges.of_elements[e][i] == edge) s.nodes[D + 1 + i] = node.point;
        return s;
    }
    [[nodiscard]] Vec<D> shift(VertexId v) const { return points[v] - mesh.linear.points[v]; }
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
    [[nodiscard]] Moves<D> moves() const {
        Moves<D> all;
        for (const EdgeId edge : nodes.set_rows()) all.nodes.emplace_back(edge, nodes[edge]);
        for (const VertexId vertex : points.set_rows()) all.points.emplace_back(vertex, points[vertex]);
        for (const ElementId e : verdicts.set_rows()) all.verdicts.emplace_back(e, verdicts[e]);
        return all;
    }
    [[nodiscard]] Proposal<D> proposal(const Proposal<D>& before) const {
        Proposal<D> after{points.column(), nodes.column(), before.kinds, {}};
        after.changes = changes_after(mesh, before, after.points, after.mid_nodes);
        return after;
    }
};

/// Judges the elements around changed nodes, or all elements if vertices moved. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<JudgedProposal<D>> judge_moved(const MovedMesh<D>& moved, const Incidence<ElementId>& shells,
                                                     const JudgedProposal<D>& before, const Execution& execution);

template <int D>
struct SegmentState {
    MovedMesh<D> moved;
    const Incidence<ElementId>& shells;
    const Column<EdgeKind>& kinds;
    const RepairOptions& options;
};

/// Tentative moves that are not yet applied to `state`.
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
    /// Returns M + θ (P − M) for the node P and the chord midpoint M: the correction of the paper (§3.2) in Lagrange
    /// form.
    [[nodiscard]] LagrangeNode<D> towards_middle(EdgeId edge, double theta) const;
    [[nodiscard]] double length(EdgeId edge) const;
    [[nodiscard]] Moves<D> moves() const;
};

enum class EdgeGroup { volume, surface, all };
[[nodiscard]] bool contains(EdgeGroup group, EdgeKind kind);

template <int D>
[[nodiscard]] std::vector<EdgeId> movable_edges(const Trial<D>& trial, ElementId e, EdgeGroup group);

template <int D>
struct Changes {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;
    std::vector<std::pair<ElementId, Verdict>> verdicts;
    std::vector<ElementId> broken;
};

/// Moves one node without updating verdicts.
template <int D>
void move_node(Trial<D>& trial, EdgeId edge, const LagrangeNode<D>& node, Changes<D>& changes);

template <int D>
void check_shells(Trial<D>& trial, std::span<const EdgeId> edges, Changes<D>& changes);

template <int D>
void undo(Trial<D>& trial, const Changes<D>& changes);

template <int D>
[[nodiscard]] BoundedJacobian<D> jacobian_with(const Trial<D>& trial, ElementId e, EdgeId edge,
                                               const LagrangeNode<D>& node);

/// `repair_element` moves single nodes by linear programs, each with minimum displacement, until the element is valid
/// or no move improves it. It prefers moves that reach the target to those that reach the bound, and these to partial
/// improvements; `steps` is the last kind allowed. True if a node moved.
enum class Steps { to_target, to_bound, helping };
template <int D>
bool repair_element(Trial<D>& trial, ElementId e, EdgeGroup group, Steps steps);

/// Moves the nodes of an element towards their chord midpoints by factors θ, and likewise the nodes of elements that
/// become invalid. Undoes all moves if an element does not reach `scaled_jacobian`, or if too many elements must move.
template <int D>
bool repair_with_neighbours(Trial<D>& trial, ElementId e, EdgeGroup group, double scaled_jacobian);

/// Moves a node towards its initial position as far as possible. True if the node moved.
template <int D>
bool put_back(Trial<D>& trial, EdgeId edge);

/// Extended nodes, and the work of the computation (unit: `RepairOptions::effort`).
template <int D>
struct LocalExtension {
    SparseMap<EdgeId, LagrangeNode<D>> nodes;
    double work = 0;
};

/// Extends the boundary displacement (`extend_boundary`) to the volume edges of `seeds` and of `rings` rings of
/// elements around them; surrounding nodes are fixed. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<LocalExtension<D>> extend_around(const MovedMesh<D>& moved, const Column<EdgeKind>& kinds,
                                                       const Incidence<ElementId>& shells,
                                                       const std::vector<ElementId>& seeds, int rings,
                                                       const Execution& execution);

/// Moves volume nodes around invalid elements to a linear extension of the boundary displacements, and likewise around
/// all elements that become invalid. Nodes of planar boundary parts slide within their planes by at most `tolerance`.
/// The boundary shape stays; the result is not necessarily better. Errors: stopped.
[[nodiscard]] Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance,
                                                  const Execution& execution);

}  // namespace camber
