module;
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.repair;
import :slides;
import :growth;
import :moved_mesh;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.curving;

namespace camber {

namespace {

/// Nodes that are nearer than this to a plane, as a share of the edge's chord, are in it.
constexpr double flat = 1e-9;

/// The unit normal of the plane in which all facets around a surface edge lie with their nodes; none if they do not.
std::optional<Vec<3>> plane_of(const QuadraticMesh<3>& mesh, const Column<LagrangeNode<3>>& nodes,
                               const Incidence<FacetId>& around, std::size_t e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    const Vec<3>& origin = mesh.linear.points[a];
    const double chord = norm(mesh.linear.points[b] - origin);
    std::optional<Vec<3>> normal;
    for (const FacetId f : around[e]) {
        const auto& v = mesh.linear.facets.vertices[f];
        const auto point = [&](int i) { return mesh.linear.points[v[i]]; };
        if (!normal) normal = normalised(cross(point(1) - point(0), point(2) - point(0)));
        for (int i = 0; i < 3; ++i) {
            const Vec<3>& node = nodes[mesh.edges.of_facets[f][i]].point;
            if (!(std::abs(dot(point(i) - origin, *normal)) <= flat * chord)) return {};
            if (!(std::abs(dot(node - origin, *normal)) <= flat * chord)) return {};
        }
    }
    return normal;
}

}  // namespace

Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance, const Execution& execution) {
    const Proposal<3>& proposal = judged.proposal();
    const QuadraticMesh<3> mesh = apply_proposal(judged.mesh(), proposal);
    const auto around = facet_shells(mesh.edges, execution);
    if (!around) return fail(around.error());
    const auto elements = shells(mesh.edges, execution);
    if (!elements) return fail(elements.error());
    std::vector<std::optional<Vec<3>>> normals(mesh.edges.size());
    Buffer<EdgeKind> kinds(proposal.kinds.begin(), proposal.kinds.end());
    for (std::size_t e = 0; e < kinds.size(); ++e) {
        if (kinds[e] != EdgeKind::surface) continue;
        normals[e] = plane_of(mesh, proposal.mid_nodes, *around, e);
        if (normals[e]) kinds[e] = EdgeKind::volume;
    }
    const Column<EdgeKind> free(std::move(kinds));
    auto extension = extend_boundary(mesh, free, proposal.mid_nodes, *elements, {}, execution);
    if (!extension) return fail(extension.error());
    Overlay<EdgeId, LagrangeNode<3>> there(Column<LagrangeNode<3>>(std::move(extension->nodes)));
    for (std::size_t e = 0; e < normals.size(); ++e) {
        if (!normals[e]) continue;
        const EdgeId edge(e);
        Vec<3> slide = there[edge].point - proposal.mid_nodes[edge].point;
        slide -= dot(slide, *normals[e]) * *normals[e];
        const double length = norm(slide);
        if (length > tolerance) slide *= (1 - 1e-9) * tolerance / length;
        there.set(edge, {proposal.mid_nodes[edge].point + slide});
    }
    const MovedMesh<3> moved(judged);
    Growth<3> growth{moved, *elements, free, there};
    grow(growth, elements_not_valid(judged.validation()), judged.validation().bound);
    Overlay<EdgeId, LagrangeNode<3>> nodes(proposal.mid_nodes);
    for (const EdgeId edge : growth.edges) nodes.set(edge, there[edge]);
    Proposal<3> slid = proposal;
    slid.mid_nodes = nodes.column();
    return slid;
}

}  // namespace camber
