module;
#include <array>
#include <cstddef>
#include <utility>
module camber.run;
import camber.core;
import camber.bezier;
import camber.crossing;
import camber.recipes;
import :check;
import :check_parts;
import :file_numbers;

namespace camber::run {

namespace {

template <int D>
FacetReport facet_report(const QuadraticMesh<D>& mesh, FacetId f, bool listed, const FileNumbers& numbers) {
    const std::size_t number = listed ? f.index() + 1 : 0;
    FacetReport report{
        .number = number, .tag = numbers.tag(D - 1, number), .reference = mesh.linear.facets.references[f]};
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
    return found.first != found.second &&
           crossing_of(straightened(nodal_facet(mesh, found.first)), straightened(nodal_facet(mesh, found.second))) !=
               Crossing::disjoint;
}

}  // namespace

template <int D>
CrossingsReport crossings_report(const LinearMesh<D>& given, const CheckedWalls<D>& walls, const FileNumbers& numbers) {
    const bool listed = given.facets.size() > 0 || given.elements.size() == 0;
    const auto& [mesh, found, overlaps] = walls;
    CrossingsReport report{.facets = mesh.linear.facets.size(),
                           .pairs = found.pairs,
                           .crossing = found.crossing,
                           .touching = found.touching,
                           .undecided = found.undecided,
                           .cut_short = found.cut_short,
                           .steps = found.steps};
    report.found.reserve(found.found.size());
    for (const FacetCrossing& pair : found.found)
        report.found.push_back(
            {pair.verdict,
             {facet_report(mesh, pair.first, listed, numbers), facet_report(mesh, pair.second, listed, numbers)},
             cross_straight(mesh, pair)});
    return report;
}

template <int D>
OverlapsReport overlaps_report(const LinearMesh<D>& given, const Overlaps<D>& overlaps, const FileNumbers& numbers) {
    OverlapsReport report{.looked_at = overlaps.looked_at,
                          .walls = overlaps.walls,
                          .overlapping = overlaps.overlapping,
                          .undecided = overlaps.undecided};
    report.found.reserve(overlaps.found.size());
    for (const ElementOverlap<D>& overlap : overlaps.found) {
        OverlapReport pair{.point = {overlap.point.c.begin(), overlap.point.c.end()}};
        for (const auto& [i, element] : {std::pair(0, overlap.first), std::pair(1, overlap.second)}) {
            pair.elements[i] = element.index() + 1;
            pair.tags[i] = numbers.tag(D, pair.elements[i]);
            pair.references[i] = given.elements.references[element];
        }
        report.found.push_back(std::move(pair));
    }
    return report;
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template CrossingsReport crossings_report<D>(const LinearMesh<D>&, const CheckedWalls<D>&, const FileNumbers&); \
    template OverlapsReport overlaps_report<D>(const LinearMesh<D>&, const Overlaps<D>&, const FileNumbers&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
