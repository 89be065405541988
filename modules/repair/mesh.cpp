// Repairs a whole mesh, counts changes, and finds the reasons why elements stay invalid.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <fmt/format.h>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.soundness;
import camber.surface;

namespace camber {

template <int D>
RepairStatistics changes_between(const JudgedProposal<D>& before, const JudgedProposal<D>& after) {
    RepairStatistics changes;
    const auto& verdicts = before.validation().verdicts;
    for (std::size_t e = 0; e < verdicts.size(); ++e)
        changes.corrected_elements += verdicts[e] != Verdict::valid && after.validation().verdicts[e] == Verdict::valid;
    const Proposal<D>& was = before.proposal();
    const Proposal<D>& is = after.proposal();
    for (std::size_t e = 0; e < was.mid_nodes.size(); ++e)
        if (is.mid_nodes[e] != was.mid_nodes[e])
            ++(was.kinds[e] == EdgeKind::volume ? changes.moved_volume_nodes : changes.moved_surface_nodes);
    for (std::size_t v = 0; v < was.points.size(); ++v) changes.moved_vertices += is.points[v] != was.points[v];
    return changes;
}

template <int D>
Repaired<D> with_all_changes(const JudgedProposal<D>& before, Repaired<D> after) {
    const RepairStatistics own = after.statistics;
    after.judged = after.judged.with_kinds(before.proposal().kinds);
    after.statistics = changes_between(before, after.judged);
    after.statistics.raised_elements = own.raised_elements;
    after.statistics.work = own.work;
    return after;
}

template <int D>
std::vector<ElementId> elements_not_valid(const Validation<D>& validation) {
    std::vector<ElementId> elements;
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e)
        if (validation.verdicts[e] != Verdict::valid) elements.emplace_back(e);
    return elements;
}

template <int D>
Column<EdgeChange> changes_after(const QuadraticMesh<D>& mesh, const Proposal<D>& before, const Column<Vec<D>>& points,
                                 const Column<LagrangeNode<D>>& mid_nodes) {
    Buffer<EdgeChange> changes(before.changes.begin(), before.changes.end());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        if (mid_nodes[e] == before.mid_nodes[e]) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        const bool straight = mid_nodes[e].point == midpoint(points[a], points[b]);
        changes[e] = straight ? EdgeChange::straightened : EdgeChange::relaxed;
    }
    return changes;
}

template <int D>
Outcome<JudgedProposal<D>> judge_moved(const MovedMesh<D>& moved, const Incidence<ElementId>& shells,
                                       const JudgedProposal<D>& before, const Execution& execution) {
    auto proposal = moved.proposal(before.proposal());
    for (const VertexId v : moved.points.set_rows())
        if (moved.points[v] != before.proposal().points[v])
            return validate(before.mesh(), std::move(proposal), before.validation().bound, execution);
    std::vector<ElementId> touched;
    for (const EdgeId edge : moved.nodes.set_rows())
        if (moved.nodes[edge] != moved.nodes.base()[edge])
            touched.insert(touched.end(), shells[edge].begin(), shells[edge].end());
    touched |= ranges::actions::sort | ranges::actions::unique;
    return before.judge_again(std::move(proposal), touched, execution);
}

template <int D>
Proposal<D> proposal_from_mesh(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& boundary_kinds,
                               RequiredBoundary required) {
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const bool straight = mesh.mid_nodes[e].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
        const bool volume = boundary_kinds[e] == EdgeKind::volume;
        changes[e] = straight ? EdgeChange::straight : volume ? EdgeChange::optimised : EdgeChange::projected;
    }
    return {mesh.linear.points, mesh.mid_nodes, kinds_with_required_fixed(mesh, boundary_kinds, required),
            std::move(changes)};
}

template <int D>
Outcome<RepairedMesh<D>> repair_mesh(Mesh<D> mesh, const MeshRepairOptions& options, const Execution& execution) {
    auto prepared = prepare(std::move(mesh), execution);
    if (!prepared) return fail(prepared.error());
    const auto quadratic = as_quadratic(std::move(prepared->mesh));
    if (!quadratic) return fail(quadratic.error());
    const QuadraticMesh<D>& sound = *quadratic;
    const auto features = find_features(
        sound.linear, sound.edges, FeatureOptions<D>{.ridge_angle_degrees = options.ridge_angle_degrees}, execution);
    if (!features) return fail(features.error());
    const auto judged = validate(sound, proposal_from_mesh(sound, features->edge_kinds, options.required_boundary),
                                 options.repair.min_scaled_jacobian, execution);
    if (!judged) return fail(judged.error());
    RepairGuide<D> guide;
    if (needs_models(options.repair.method)) {
        const auto around = shells(sound.edges, execution);
        if (!around) return fail(around.error());
        auto result = guide_from_mesh(*judged, *around, execution);
        if (!result) return fail(result.error());
        guide = std::move(*result);
    }
    auto repaired = repair_within(*judged, guide, options.repair, execution);
    if (!repaired) return fail(repaired.error());
    const JudgedProposal<D>& after = repaired->judged;
    return RepairedMesh<D>{as_mesh(commit_uncertified(after).mesh),
                           judged->validation(),
                           after.validation(),
                           repaired->statistics,
                           boundary_shift(sound, after.proposal()),
                           remaining(*repaired),
                           std::move(prepared->notices)};
}

namespace {

template <int D>
double determinant(const std::array<Vec<D>, D>& c) {
    if constexpr (D == 2)
        return det(c[0], c[1]);
    else
        return det(c[0], c[1], c[2]);
}

/// Returns det J / det straight at local vertex i. The columns of J are 4 P_ij − 3 P_i − P_j with the node P_ij of edge
/// i–j.
template <int D>
double at_vertex(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, std::size_t e, int i) {
    const auto& vertices = mesh.linear.elements.vertices[e];
    const Vec<D>& p = mesh.linear.points[vertices[i]];
    std::array<Vec<D>, D> curved{}, straight{};
    int column = 0;
    for (int edge = 0; edge < edges_per_simplex<D>; ++edge) {
        const auto [a, b] = local_edges<D>[edge];
        if (a != i && b != i) continue;
        const Vec<D>& q = mesh.linear.points[vertices[a == i ? b : a]];
        const Vec<D>& node = proposal.mid_nodes[mesh.edges.of_elements[e][edge]].point;
        curved[column] = 4.0 * node - 3.0 * p - q;
        straight[column] = q - p;
        ++column;
    }
    return determinant<D>(curved) / determinant<D>(straight);
}

template <int D>
bool is_prescribed(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, std::size_t e, int i) {
    for (int edge = 0; edge < edges_per_simplex<D>; ++edge) {
        const auto [a, b] = local_edges<D>[edge];
        if ((a == i || b == i) && proposal.kinds[mesh.edges.of_elements[e][edge]] == EdgeKind::volume) return false;
    }
    return true;
}

template <int D>
bool is_flat(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& v = mesh.linear.elements.vertices[e];
    std::array<Vec<D>, D> columns{};
    for (int i = 0; i < D; ++i) columns[i] = mesh.linear.points[v[i + 1]] - mesh.linear.points[v[0]];
    return !(determinant<D>(columns) > 0);
}

/// A vertex where the normal of a boundary facet points against that of the straight facet.
struct Fold {
    VertexId vertex;
    double jacobian = 0;
};
template <int D>
using Folds = std::map<std::array<VertexId, D>, Fold>;

template <int D>
Folds<D> find_folds(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    Folds<D> folds;
    if constexpr (D == 3)
        for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
            auto v = mesh.linear.facets.vertices[f];
            const auto point = [&](int i) { return mesh.linear.points[v[i % 3]]; };
            const auto node = [&](int i) { return proposal.mid_nodes[mesh.edges.of_facets[f][i % 3]].point; };
            const Vec<3> straight = cross(point(1) - point(0), point(2) - point(0));
            // Edge i of a triangle connects the vertices i and i + 1.
            for (int i = 0; i < 3; ++i) {
                const Vec<3> along = 4.0 * node(i) - 3.0 * point(i) - point(i + 1);
                const Vec<3> back = 4.0 * node(i + 2) - 3.0 * point(i) - point(i + 2);
                const double jacobian = dot(cross(along, back), straight) / norm_squared(straight);
                if (jacobian > 0) continue;
                std::array<VertexId, 3> key{v[0], v[1], v[2]};
                std::ranges::sort(key);
                folds.insert({key, {v[i], jacobian}});
                break;
            }
        }
    return folds;
}

template <int D>
const Fold* fold_of(const QuadraticMesh<D>& mesh, const Folds<D>& folds, std::size_t e) {
    const auto& v = mesh.linear.elements.vertices[e];
    for (int opposite = 0; opposite <= D; ++opposite) {
        std::array<VertexId, D> key;
        for (int i = 0, n = 0; i <= D; ++i)
            if (i != opposite) key[n++] = v[i];
        std::ranges::sort(key);
        if (const auto found = folds.find(key); found != folds.end()) return &found->second;
    }
    return nullptr;
}

template <int D>
std::string required_of(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Buffer<std::uint8_t>& required,
                        std::size_t e) {
    int edges = 0, vertices = 0;
    for (const EdgeId edge : mesh.edges.of_elements[e]) edges += proposal.kinds[edge] == EdgeKind::fixed;
    for (const VertexId v : mesh.linear.elements.vertices[e]) vertices += required[v.index()] != 0;
    if (edges > 0) return fmt::format("{} of its {} edges are required and cannot move", edges, edges_per_simplex<D>);
    if (vertices > 0) return fmt::format("{} of its {} vertices are required and cannot move", vertices, D + 1);
    return {};
}

struct Reason {
    std::string what;
    VertexId at = {};
};

template <int D>
Reason reason_of(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Validation<D>& validation,
                 const Folds<D>& folds, std::size_t e) {
    if (is_flat(mesh, e)) return {"its vertices alone make it flat or inverted"};
    for (int i = 0; i <= D; ++i) {
        if (!is_prescribed(mesh, proposal, e, i)) continue;
        const double input = at_vertex(mesh, proposal, e, i);
        if (!(input > validation.bound))
            return {fmt::format("the boundary alone makes its scaled Jacobian {:.3g}", input),
                    mesh.linear.elements.vertices[e][i]};
    }
    if (const Fold* fold = fold_of<D>(mesh, folds, e))
        return {fmt::format("its boundary triangle is folded: scaled Jacobian {:.3g}", fold->jacobian), fold->vertex};
    int free = 0;
    for (const EdgeId edge : mesh.edges.of_elements[e]) free += proposal.kinds[edge] == EdgeKind::volume;
    if (free == 0) return {"all its nodes are on the boundary"};
    if (validation.verdicts[e] == Verdict::undecided) return {"too close to the bound to be decided"};
    return {fmt::format("no valid position was found for its {} in the volume",
                        free == 1 ? "node" : std::to_string(free) + " nodes")};
}

template <int D>
bool is_unresolved(const Repaired<D>& repaired, std::size_t e) {
    return std::ranges::binary_search(repaired.unresolved, ElementId(e));
}

}  // namespace

std::string sentence_of(const RemainingElement& element, std::string_view vertex) {
    return element.reason + (element.at.valid() ? fmt::format(" at vertex {}", vertex) : std::string()) +
           (element.is_unresolved ? "; the work limit was reached (option effort)" : "");
}

template <int D>
std::vector<RemainingElement> remaining(const Repaired<D>& repaired) {
    if constexpr (D == 3)
        if (is_standalone_surface(repaired.judged.mesh().linear)) return remaining_triangles(repaired);
    const Proposal<D>& proposal = repaired.judged.proposal();
    const Validation<D>& validation = repaired.judged.validation();
    const QuadraticMesh<D> mesh = apply_proposal(repaired.judged.mesh(), proposal);
    const Folds<D> folds = find_folds<D>(mesh, proposal);
    const auto required = required_vertices(mesh.linear);
    std::vector<RemainingElement> all;
    all.reserve(validation.invalid + validation.undecided);
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e) {
        if (validation.verdicts[e] == Verdict::valid) continue;
        Reason reason{required_of<D>(mesh, proposal, required, e)};
        if (reason.what.empty()) reason = reason_of<D>(mesh, proposal, validation, folds, e);
        all.push_back({ElementId(e), std::move(reason.what), reason.at, is_unresolved(repaired, e)});
    }
    return all;
}

template <int D>
std::vector<RemainingElement> remaining_by_limits(const Repaired<D>& repaired) {
    if (is_standalone_surface(repaired.judged.mesh().linear)) return remaining(repaired);
    const QuadraticMesh<D>& mesh = repaired.judged.mesh();
    const auto required = required_vertices(mesh.linear);
    const auto& verdicts = repaired.judged.validation().verdicts;
    std::vector<RemainingElement> all;
    for (std::size_t e = 0; e < verdicts.size(); ++e) {
        if (verdicts[e] == Verdict::valid) continue;
        std::string reason = required_of<D>(mesh, repaired.judged.proposal(), required, e);
        if (reason.empty() && !is_unresolved(repaired, e)) continue;
        if (reason.empty()) reason = "not repaired";
        all.push_back({ElementId(e), std::move(reason), {}, is_unresolved(repaired, e)});
    }
    return all;
}

template <int D>
BoundaryShift boundary_shift(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    BoundaryShift shifts;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (proposal.kinds[e] == EdgeKind::volume || proposal.mid_nodes[e] == mesh.mid_nodes[e]) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        const double shift = norm(proposal.mid_nodes[e].point - mesh.mid_nodes[e].point);
        const double chord = norm(mesh.linear.points[b] - mesh.linear.points[a]);
        ++shifts.moved_nodes;
        shifts.largest = std::max(shifts.largest, shift);
        if (chord > 0) shifts.largest_relative = std::max(shifts.largest_relative, shift / chord);
    }
    return shifts;
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template RepairStatistics changes_between<D>(const JudgedProposal<D>&, const JudgedProposal<D>&);                \
    template Repaired<D> with_all_changes<D>(const JudgedProposal<D>&, Repaired<D>);                                 \
    template std::vector<ElementId> elements_not_valid<D>(const Validation<D>&);                                     \
    template Column<EdgeChange> changes_after<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Column<Vec<D>>&, \
                                                 const Column<LagrangeNode<D>>&);                                    \
    template Outcome<JudgedProposal<D>> judge_moved<D>(const MovedMesh<D>&, const Incidence<ElementId>&,             \
                                                       const JudgedProposal<D>&, const Execution&);                  \
    template Proposal<D> proposal_from_mesh<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&, RequiredBoundary);  \
    template Outcome<RepairedMesh<D>> repair_mesh<D>(Mesh<D>, const MeshRepairOptions&, const Execution&);           \
    template std::vector<RemainingElement> remaining<D>(const Repaired<D>&);                                         \
    template std::vector<RemainingElement> remaining_by_limits<D>(const Repaired<D>&);                               \
    template BoundaryShift boundary_shift<D>(const QuadraticMesh<D>&, const Proposal<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
