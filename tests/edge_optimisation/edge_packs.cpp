// Packed edge searches compared with single searches.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
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

/// All edges of a back mesh, with nodes in their middles.
template <int D>
struct Edges {
    EdgeSet<D> set;
    Incidence<ElementId> around;
    std::vector<BackEdge> edges;
    std::vector<LagrangeNode<D>> middles;

    explicit Edges(const KnownBack<D>& back)
        : set(must(unique_edges(back.mesh, testing::one_thread))), around(must(shells(set, testing::one_thread))) {
        for (std::size_t e = 0; e < set.size(); ++e) {
            const auto& [a, b] = set.vertices[e];
            edges.push_back({a, b, around[e]});
            middles.push_back({midpoint(back.mesh.points[a], back.mesh.points[b])});
        }
    }
};

template <int D>
double length_of(const KnownBack<D>& back, const BackEdge& edge, const LagrangeNode<D>& node) {
    const QuadraticEdge<D> curve{back.mesh.points[edge.a], node, back.mesh.points[edge.b]};
    return riemannian_length(back, curve, gauss_legendre(report_points), edge.shell.front()).length;
}

template <int D>
std::vector<EdgeMinimum<D>> searched(const BackMesh<D>& back, const Edges<D>& all, const EdgeMinimiserOptions& options,
                                     Instructions set = widest_instructions()) {
    std::vector<EdgeMinimum<D>> minima(all.edges.size());
    minimise_back_edges<D>(back, {all.edges, all.middles}, edge_rules(options), options, minima, set);
    return minima;
}

template <int D>
void check_packs() {
    for (const auto kind : {EdgeObjectiveKind::energy, EdgeObjectiveKind::length})
        for (const Field<D>& field : fields<D>) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(field.name);
            EdgeMinimiserOptions options;
            options.objective = kind;
            property("packed searches are as short as single ones, bounded in shift, at most the chord",
                     [&](std::uint64_t seed) {
                         const int n = D == 2 ? 10 : 3;
                         const auto back = field.build(seed + 1, n);
                         const Edges<D> all(back);
                         const auto minima = searched<D>(back, all, options);
                         const EdgeRules rules = edge_rules(options);
                         double in_packs = 0;
                         double by_itself = 0;
                         for (std::size_t i = 0; i < minima.size(); ++i) {
                             const auto& edge = all.edges[i];
                             const double chord = length_of(back, edge, all.middles[i]);
                             const double length = length_of(back, edge, minima[i].node);
                             RC_ASSERT(length <= chord * (1 + 1e-12));
                             const Vec<D> e = back.mesh.points[edge.b] - back.mesh.points[edge.a];
                             const double shift = dot(minima[i].node.point - all.middles[i].point, e) / norm_squared(e);
                             RC_ASSERT(std::abs(shift) <= options.max_tangential_shift + 1e-9);
                             in_packs += length / chord;
                             by_itself +=
                                 minimise_back_edge<D>(back, edge, all.middles[i], rules, options).length / chord;
                         }
                         RC_ASSERT(in_packs <= by_itself * field.max_mean);
                     },
                     {.count = 6});
            property("the search of an edge does not depend on its pack or the instruction set",
                     [&](std::uint64_t seed) {
                         Dice dice(seed);
                         const int n = D == 2 ? 8 : 3;
                         const auto back = field.build(seed + 1, n);
                         const Edges<D> all(back);
                         const auto together = searched<D>(back, all, options, Instructions::baseline);
                         for (const Instructions set : {Instructions::avx2, Instructions::avx512}) {
                             if (!has(set)) continue;
                             const auto other = searched<D>(back, all, options, set);
                             for (std::size_t i = 0; i < other.size(); ++i) RC_ASSERT(same(other[i], together[i]));
                         }
                         for (int k = 0; k < 10; ++k) {
                             const std::size_t e = dice.below(all.edges.size());
                             EdgeMinimum<D> own;
                             minimise_back_edges<D>(back, {{&all.edges[e], 1}, {&all.middles[e], 1}},
                                                    edge_rules(options), options, {&own, 1});
                             RC_ASSERT(same(own, together[e]));
                         }
                     },
                     {.count = 6});
        }
    property("no packed edge needs a single search because of its field",
             [&](std::uint64_t seed) {
                 const auto back = turning<D>(seed + 1, 4);
                 const Edges<D> all(back);
                 std::vector<EdgeMinimum<D>> minima(all.edges.size());
                 const EdgeSearchWork work =
                     minimise_back_edges<D>(back, {all.edges, all.middles}, edge_rules({}), {}, minima);
                 RC_ASSERT(work.single == 0u);
             },
             {.count = 6});
    property("packed edges stay straight in a constant metric, to the last bit",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const LogMetric<D> l{dice.symmetric<D>(5)};
                 const auto back = back_of(unit_box<D>(3, seed + 1), [&](const Vec<D>&) { return l; });
                 const Edges<D> all(back);
                 const auto minima = searched<D>(back, all, {});
                 for (std::size_t i = 0; i < minima.size(); ++i) RC_ASSERT(minima[i].node == all.middles[i]);
             },
             {.count = 10});
    property("packed nodes are finite and edges at most their chords at any anisotropy",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto back = rough_back(unit_box<D>(3, seed + 1), dice, dice.uniform(1, 8));
                 const Edges<D> all(back);
                 const auto minima = searched<D>(back, all, {});
                 for (std::size_t i = 0; i < minima.size(); ++i) {
                     RC_ASSERT(is_finite(minima[i].node.point));
                     RC_ASSERT(length_of(back, all.edges[i], minima[i].node) <=
                               length_of(back, all.edges[i], all.middles[i]) * (1 + 1e-6));
                 }
             },
             {.count = 10});
}

}  // namespace

TEST_CASE("packed edge searches are as short as single searches and no longer than the chord, 2D") { check_packs<2>(); }
TEST_CASE("packed edge searches are as short as single searches and no longer than the chord, 3D") { check_packs<3>(); }
