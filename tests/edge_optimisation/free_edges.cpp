// Packed searches of edges that do not belong to the back mesh, compared with single searches.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "back.hpp"
#include "edge_fields.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

/// Edges of about one cell length at random positions in a back mesh.
template <int D>
std::vector<FreeEdge<D>> edges_in(const KnownBack<D>& back, int n, std::uint64_t seed) {
    Dice dice(seed);
    std::vector<FreeEdge<D>> edges;
    const ElementId first(std::size_t{0});
    while (edges.size() < 60) {
        const auto& element = back.mesh.elements.vertices[ElementId(dice.below(back.mesh.elements.size()))];
        const Vec<D> a = midpoint(back.mesh.points[element[0]], back.mesh.points[element[1]]);
        Vec<D> b = a;
        for (int i = 0; i < D; ++i) b[i] += dice.uniform(-1, 1) / n;
        const FieldSample<D> from = sample_value<D>(back, a, first);
        const FieldSample<D> to = sample_value<D>(back, b, from.location.element);
        if (to.location.placement != Placement::inside) continue;
        edges.push_back({{a, from.log_metric}, {b, to.log_metric}, from.location.element});
    }
    return edges;
}

template <int D>
double length_of(const KnownBack<D>& back, const FreeEdge<D>& edge, const LagrangeNode<D>& node) {
    return riemannian_length<D>(back, {edge.a.point, node, edge.b.point}, gauss_legendre(report_points), edge.hint)
        .length;
}

template <int D>
std::vector<EdgeMinimum<D>> searched(const BackMesh<D>& back, const std::vector<FreeEdge<D>>& edges,
                                     const EdgeMinimiserOptions& options, Instructions set = widest_instructions()) {
    std::vector<EdgeMinimum<D>> minima(edges.size());
    minimise_edges<D>(back, edges, edge_rules(options), options, minima, set);
    return minima;
}

template <int D>
void never_longer(const Field<D>& field, const EdgeMinimiserOptions& options, std::uint64_t seed) {
    const int n = D == 2 ? 10 : 3;
    const auto back = field.build(seed + 1, n);
    const auto edges = edges_in<D>(back, n, seed + 2);
    const auto minima = searched<D>(back, edges, options);
    const EdgeRules rules = edge_rules(options);
    double in_packs = 0;
    double by_itself = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& [a, b, hint] = edges[i];
        const double chord = length_of(back, edges[i], {midpoint(a.point, b.point)});
        const double length = length_of(back, edges[i], minima[i].node);
        RC_ASSERT(length <= chord * (1 + 1e-9));
        in_packs += length / chord;
        by_itself += minimise_edge<D>(back, a.point, b.point, hint, rules, options).length / chord;
    }
    RC_ASSERT(in_packs <= by_itself * field.max_mean);
}

template <int D>
void same_bytes(const Field<D>& field, const EdgeMinimiserOptions& options, std::uint64_t seed) {
    const int n = D == 2 ? 8 : 3;
    const auto back = field.build(seed + 1, n);
    const auto edges = edges_in<D>(back, n, seed + 2);
    const auto together = searched<D>(back, edges, options, Instructions::baseline);
    for (const Instructions set : {Instructions::avx2, Instructions::avx512}) {
        if (!has(set)) continue;
        const auto other = searched<D>(back, edges, options, set);
        for (std::size_t i = 0; i < other.size(); ++i) RC_ASSERT(same(other[i], together[i]));
    }
    for (std::size_t i = 0; i < edges.size(); i += 7)
        RC_ASSERT(same(searched<D>(back, {edges[i]}, options)[0], together[i]));
}

template <int D>
void check_free_edges() {
    for (const auto kind : {EdgeObjectiveKind::energy, EdgeObjectiveKind::length})
        for (const Field<D>& field : fields<D>) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(field.name);
            EdgeMinimiserOptions options;
            options.objective = kind;
            property("free edges are at most the chord and on average as short as single searches",
                     [&](std::uint64_t seed) { never_longer(field, options, seed); }, {.count = 4});
            property("the search of a free edge does not depend on its pack or the instruction set",
                     [&](std::uint64_t seed) { same_bytes(field, options, seed); }, {.count = 4});
        }
    property("at most a tenth of the free edges needs a single search",
             [](std::uint64_t seed) {
                 const auto back = layers<D>(seed + 1, 4);
                 const auto edges = edges_in<D>(back, 8, seed + 2);
                 std::vector<EdgeMinimum<D>> minima(edges.size());
                 const EdgeSearchWork work = minimise_edges<D>(back, edges, edge_rules({}), {}, minima);
                 RC_ASSERT(work.single * 10 <= edges.size());
             },
             {.count = 6});
}

}  // namespace

TEST_CASE("packed searches of free edges are as short as single searches, 2D") { check_free_edges<2>(); }
TEST_CASE("packed searches of free edges are as short as single searches, 3D") { check_free_edges<3>(); }
