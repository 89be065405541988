module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.validity;
import camber.curving;
import :mend;

namespace camber::run {

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

/// The element with the extended nodes of the edges that are chosen.
Verdict verdict_of(const QuadraticMesh<3>& mesh, const Column<LagrangeNode<3>>& nodes,
                   const std::vector<LagrangeNode<3>>& extended, const std::vector<std::uint8_t>& chosen, ElementId e,
                   double bound) {
    NodalSimplex<3> s;
    for (int i = 0; i < 4; ++i) s.nodes[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (int i = 0; i < edges_per_simplex<3>; ++i) {
        const EdgeId edge = mesh.edges.of_elements[e][i];
        s.nodes[4 + i] = (chosen[edge.index()] != 0 ? extended[edge.index()] : nodes[edge]).point;
    }
    return decide(s, bound);
}

}  // namespace

Outcome<Proposal<3>> slid_in_planes(const JudgedProposal<3>& judged, double tolerance, const Execution& execution) {
    const Proposal<3>& proposal = judged.proposal();
    const Validation<3>& validation = judged.validation();
    const QuadraticMesh<3> mesh = proposed(judged.mesh(), proposal);
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
    const auto extension = extend_boundary(mesh, free, proposal.mid_nodes, *elements, {}, execution);
    if (!extension) return fail(extension.error());
    std::vector<LagrangeNode<3>> extended(extension->nodes.begin(), extension->nodes.end());
    for (std::size_t e = 0; e < extended.size(); ++e) {
        if (!normals[e]) continue;
        Vec<3> slide = extended[e].point - proposal.mid_nodes[e].point;
        slide -= dot(slide, *normals[e]) * *normals[e];
        const double length = norm(slide);
        if (length > tolerance) slide *= (1 - 1e-9) * tolerance / length;
        extended[e].point = proposal.mid_nodes[e].point + slide;
    }
    // Outwards from what is not valid, as far as extended nodes break what is next to them.
    std::vector<std::uint8_t> chosen(mesh.edges.size(), 0);
    std::vector<ElementId> queue;
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e)
        if (validation.verdicts[e] != Verdict::valid) queue.push_back(ElementId(e));
    while (!queue.empty()) {
        std::vector<ElementId> next;
        for (const ElementId e : queue)
            for (const EdgeId edge : mesh.edges.of_elements[e]) {
                if (free[edge] != EdgeKind::volume || std::exchange(chosen[edge.index()], std::uint8_t{1}) != 0)
                    continue;
                next.insert(next.end(), (*elements)[edge].begin(), (*elements)[edge].end());
            }
        std::ranges::sort(next);
        const auto repeated = std::ranges::unique(next);
        next.erase(repeated.begin(), repeated.end());
        std::erase_if(next, [&](ElementId e) {
            return verdict_of(mesh, proposal.mid_nodes, extended, chosen, e, validation.bound) == Verdict::valid;
        });
        queue = std::move(next);
    }
    Buffer<LagrangeNode<3>> nodes(proposal.mid_nodes.begin(), proposal.mid_nodes.end());
    for (std::size_t e = 0; e < nodes.size(); ++e)
        if (chosen[e] != 0) nodes[e] = extended[e];
    Proposal<3> slid = proposal;
    slid.mid_nodes = std::move(nodes);
    return slid;
}

}  // namespace camber::run
