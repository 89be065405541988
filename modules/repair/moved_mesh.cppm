module;
#include <array>
#include <cstddef>
#include <utility>
#include <vector>
module camber.repair:moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;
import :repaired;

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

}  // namespace camber
