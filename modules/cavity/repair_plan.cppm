module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.cavity:repair_plan;
import camber.core;
import camber.bezier;
import camber.validity;
import :edge_models;
import :repair;

namespace camber {

/// A mesh while it is repaired.
template <int D>
struct RepairState {
    const QuadraticMesh<D>& mesh;  ///< topology; its points and nodes are not looked at
    const Incidence<ElementId>& shells;
    const Incidence<ElementId>& balls;
    const Column<EdgeModel<D>>& models;
    const RepairOptions& options;
    Column<EdgeKind> kinds;
    Buffer<std::uint8_t> on_boundary;  ///< of vertices: 1 if they must stay
    Buffer<Vec<D>> points;
    Buffer<Vec<D>> shifts;  ///< of vertices: how far each is from where it was
    Buffer<LagrangeNode<D>> nodes;
    Buffer<Verdict> verdicts;

    [[nodiscard]] bool good(ElementId e) const { return verdicts[e.index()] == Verdict::valid; }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> s;
        for (int i = 0; i <= D; ++i) s.nodes[i] = points[mesh.linear.elements.vertices[e][i].index()];
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            s.nodes[D + 1 + i] = nodes[mesh.edges.of_elements[e][i].index()].point;
        return s;
    }
};

/// What a cavity may move, and how far it reaches around its element.
struct Reach {
    enum class Moves : std::uint8_t { volume_nodes, vertices, surface_nodes };
    Moves moves = Moves::volume_nodes;
    int closures = 0;  ///< 0: the element's own edges; each more: those of all elements around these
};

/// What a cavity holds: its elements are those around its free edges and vertices.
template <int D>
struct RepairCavity {
    std::vector<EdgeId> edges;       ///< free, rising
    std::vector<VertexId> vertices;  ///< free, rising
    std::vector<ElementId> elements;
};
template <int D>
[[nodiscard]] RepairCavity<D> repair_cavity(const RepairState<D>& state, ElementId seed, Reach reach);

/// What is to change, planned against a state.
template <int D>
struct RepairPlan {
    std::vector<std::pair<EdgeId, LagrangeNode<D>>> nodes;
    std::vector<std::pair<VertexId, Vec<D>>> points;
    std::vector<std::pair<ElementId, Verdict>> verdicts;
};

/// Mends the cavity's seed; no other element that is good enough stops being so. None when that is not found.
template <int D>
[[nodiscard]] std::optional<RepairPlan<D>> plan_repair(const RepairState<D>& state, const RepairCavity<D>& cavity,
                                                       ElementId seed);

}  // namespace camber
