module;
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
module camber.run;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.soundness;
import :check;
import :check_parts;

namespace camber::run {

namespace {

/// The mesh with its boundary listed, where nothing of it is; none where it cannot be.
template <int D>
std::optional<QuadraticMesh<D>> with_boundary(const QuadraticMesh<D>& mesh, const Execution& execution) {
    auto prepared = prepare(mesh, execution);
    if (!prepared) return {};
    return std::move(prepared->mesh);
}

template <int D>
FacetReport facet_report(const QuadraticMesh<D>& mesh, FacetId f, bool listed, const FileNumbers& numbers) {
    FacetReport report{.number = listed ? f.index() + 1 : 0, .reference = mesh.linear.facets.references[f]};
    report.vertices.reserve(D);
    for (const VertexId v : mesh.linear.facets.vertices[f]) report.vertices.push_back(numbers(v.index()));
    return report;
}

template <int D>
NodalFacet<D> straightened(const NodalFacet<D>& facet) {
    std::array<Vec<D>, D> vertices;
    for (int i = 0; i < D; ++i) vertices[i] = facet.nodes[i];
    return straight_facet<D>(vertices);
}

template <int D>
bool cross_straight(const QuadraticMesh<D>& mesh, const FacetCrossing& found) {
    return found.first != found.second && crossing_of(straightened(nodal_facet(mesh, found.first)),
                                                      straightened(nodal_facet(mesh, found.second))) != Crossing::clear;
}

}  // namespace

template <int D>
Outcome<CrossingsReport> crossings_report(const QuadraticMesh<D>& mesh, const FileNumbers& numbers,
                                          const Execution& execution) {
    const bool listed = mesh.linear.facets.size() > 0 || mesh.linear.elements.size() == 0;
    const std::optional<QuadraticMesh<D>> made =
        listed ? std::optional(mesh) : with_boundary(mesh, part_of(execution, 0, 0.7));
    if (!made) return CrossingsReport{.looked_at = false};
    const auto found = find_crossings(*made, part_of(execution, listed ? 0 : 0.7, 1));
    if (!found) return fail(found.error());
    CrossingsReport report{.facets = made->linear.facets.size(),
                           .pairs = found->pairs,
                           .crossing = found->crossing,
                           .touching = found->touching,
                           .undecided = found->undecided,
                           .cut_short = found->cut_short,
                           .steps = found->steps};
    report.found.reserve(found->found.size());
    for (const FacetCrossing& pair : found->found)
        report.found.push_back(
            {pair.verdict,
             {facet_report(*made, pair.first, listed, numbers), facet_report(*made, pair.second, listed, numbers)},
             cross_straight(*made, pair)});
    return report;
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<CrossingsReport> crossings_report<D>(const QuadraticMesh<D>&, const FileNumbers&, \
                                                          const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
