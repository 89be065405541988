// Repair: what is not good enough is mended at a small loss, and nothing else is spoilt.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <utility>
#include <vector>

#include "block.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.optimisation;
import camber.soundness;
import camber.curving;
import camber.repair;

using namespace camber;
using namespace camber::testing;

namespace {

/// The block with its boundary on the spheres and volume nodes thrown about by up to `amplitude` chords.
template <int D>
Proposal<D> thrown(const Block<D>& b, std::uint64_t seed, double amplitude) {
    Dice dice(seed);
    const std::size_t n = b.mesh.edges.size();
    Buffer<LagrangeNode<D>> nodes(b.boundary_nodes.begin(), b.boundary_nodes.end());
    Buffer<EdgeChange> changes(n, EdgeChange::straight);
    for (std::size_t e = 0; e < n; ++e) {
        if (b.kinds[e] != EdgeKind::volume) continue;
        const auto [p, q] = b.mesh.edges.vertices[e];
        const double length = distance(b.mesh.linear.points[p], b.mesh.linear.points[q]);
        for (int i = 0; i < D; ++i) nodes[e].point[i] += amplitude * length * dice.uniform(-1, 1);
        changes[e] = EdgeChange::optimised;
    }
    return {b.mesh.linear.points, std::move(nodes), b.kinds, std::move(changes)};
}

template <int D>
RepairGuide<D> guide_of(const Block<D>& b, const Proposal<D>& proposal) {
    return {b.shells, [nodes = proposal.mid_nodes](EdgeId e) { return nodes[e]; },
            edge_models(CurvingAim::energy, b.mesh, proposal.mid_nodes, b.shells, b.back)};
}

template <int D>
Repaired<D> repaired(const Block<D>& b, const Proposal<D>& p, const RepairOptions& options, int threads = 1) {
    const auto judged = must(validate(b.mesh, p, options.min_scaled_jacobian, alone));
    return must(repair(judged, guide_of(b, p), options, Execution{threads}));
}

/// What the nodes cost by the models, over the volume edges.
template <int D>
double cost(const Block<D>& b, const Proposal<D>& wanted, const Proposal<D>& got) {
    const auto guide = guide_of(b, wanted);
    double sum = 0;
    for (std::size_t e = 0; e < b.kinds.size(); ++e)
        if (b.kinds[e] == EdgeKind::volume) sum += guide.models(EdgeId(e))(got.mid_nodes[e].point);
    return sum;
}

template <int D>
std::array<Vec<D>, D + 1> corners(const LinearMesh<D>& mesh, const Column<Vec<D>>& points, std::size_t e) {
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[static_cast<std::size_t>(i)] = points[mesh.elements.vertices[e][i]];
    return p;
}

/// A vertex of the volume is thrown over the other side of its ball; where repair puts it, and others that make room,
/// the elements around hold the bound over their determinants of before too, and keep a shape.
template <int D>
void vertices_that_move(const std::array<int, D>& cells) {
    std::size_t moves = 0;
    // Guards against a repaired vertex that leaves a sliver.
    property("vertices that move leave what they must",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 auto b = shell_block<D>(cells, seed + 1);
                 auto points = take(b.mesh.linear.points);
                 const auto on = boundary_marks(b);
                 for (std::size_t v = 0; v < points.size(); ++v)
                     if (on[v] == 0 && dice.below(3) == 0) points[v] += dice.vector<D>(-1, 1);
                 b.mesh.linear.points = std::move(points);
                 b.mesh = must(elevate(b.mesh.linear, alone));
                 const LinearMesh<D>& mesh = b.mesh.linear;
                 RepairOptions options;
                 options.min_scaled_jacobian = dice.below(2) == 0 ? 1e-9 : 0.2;
                 const auto straight = must(curve_boundary(b.mesh, b.kinds, b.mesh.mid_nodes, alone)).proposal;
                 const auto judged = must(validate(b.mesh, straight, options.min_scaled_jacobian, alone));
                 const RepairGuide<D> guide{b.shells, [nodes = b.mesh.mid_nodes](EdgeId e) { return nodes[e]; },
                                            implied_edge_models(b.mesh, b.mesh.mid_nodes, b.shells)};
                 const auto r = must(repair(judged, guide, options, alone));
                 const Proposal<D>& after = r.judged.proposal();
                 moves += r.statistics.moved_vertices;
                 for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
                     const auto was = corners<D>(mesh, mesh.points, e);
                     const auto is = corners<D>(mesh, after.points, e);
                     const bool valid = r.judged.validation().verdicts[e] == Verdict::valid;
                     if (was == is || !valid || !(mean_ratio<D>(was) > 1e-6)) continue;
                     RC_ASSERT(mean_ratio<D>(is) >= std::min(mean_ratio<D>(was), 0.05));
                     const double share = signed_measure<D>(was) / signed_measure<D>(is);
                     const auto element =
                         nodal_element<D>(apply_proposal(b.mesh, after), after.mid_nodes.view(), ElementId(e));
                     RC_ASSERT(decide(element, options.min_scaled_jacobian * share) == Verdict::valid);
                 }
             },
             {D == 2 ? 8 : 3});
    CHECK(moves > 0);
}

/// Elements after a repair to the default bound, and raised to a target beyond it.
template <int D>
void raised(const std::array<int, D>& cells) {
    std::size_t gained = 0;
    property("raised elements",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto wanted = thrown(b, seed + 2, dice.uniform(0.05, 0.3));
                 RepairOptions options;
                 if (dice.below(2) == 0) options.min_scaled_jacobian = dice.uniform(0.05, 0.25);
                 const auto to_bound = [&](double target, int threads) {
                     options.target = target;
                     const auto judged = must(validate(b.mesh, wanted, options.min_scaled_jacobian, alone));
                     return must(repair_or_straighten(judged, guide_of(b, wanted), options, Execution{threads}));
                 };
                 const auto before = to_bound(default_bound, 1);
                 const double target = dice.uniform(0.3, 0.8);
                 const auto after = to_bound(target, 1);
                 RC_ASSERT(after.judged.validation().bound == options.min_scaled_jacobian.value);
                 RC_ASSERT(after.judged.validation().not_valid() <= before.judged.validation().not_valid());
                 for (std::size_t e = 0; e < b.mesh.linear.elements.size(); ++e)
                     if (before.judged.validation().verdicts[e] == Verdict::valid)
                         RC_ASSERT(after.judged.validation().verdicts[e] == Verdict::valid);
                 RC_ASSERT(after.judged.proposal().mid_nodes == to_bound(target, 3).judged.proposal().mid_nodes);
                 RC_ASSERT(after.judged.proposal().points == before.judged.proposal().points);
                 for (std::size_t e = 0; e < b.kinds.size(); ++e)
                     if (b.kinds[e] != EdgeKind::volume)
                         RC_ASSERT(after.judged.proposal().mid_nodes[e] == before.judged.proposal().mid_nodes[e]);
                 const auto smallest = [&](const Repaired<D>& r, std::size_t e) {
                     const auto& nodes = r.judged.proposal().mid_nodes;
                     return check_element(nodal_element<D>(b.mesh, nodes.view(), ElementId(e)), 0).min_scaled_jacobian;
                 };
                 std::size_t certainly = 0, perhaps = 0;  // raised: values are certified to 1e-3
                 for (std::size_t e = 0; e < b.mesh.linear.elements.size(); ++e) {
                     const double was = smallest(before, e), is = smallest(after, e);
                     if (before.judged.validation().verdicts[e] == Verdict::valid) {
                         certainly += was < target - 3e-3 && is > target + 3e-3 ? 1 : 0;
                         perhaps += was < target + 3e-3 && is > target - 3e-3 ? 1 : 0;
                     }
                     if (was > 2 * min_bound) RC_ASSERT(is >= std::min(target, was) - 3e-3);
                     gained += was < target && is >= target ? 1 : 0;
                 }
                 RC_ASSERT(before.statistics.raised_elements == 0);
                 RC_ASSERT(after.statistics.raised_elements >= certainly);
                 RC_ASSERT(after.statistics.raised_elements <= perhaps);
             },
             {D == 2 ? 10 : 4});
    CHECK(gained > 0);
}

template <int D>
void laws(const std::array<int, D>& cells) {
    property("repair mends, spoils nothing, keeps the boundary, and tells what it did",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto before = thrown(b, seed + 2, dice.uniform(0.1, 0.4));
                 RepairOptions options;
                 options.min_scaled_jacobian = dice.below(2) == 0 ? 1e-12 : 0.1;
                 options.method = dice.below(4) == 0   ? RepairMethod::edge
                                  : dice.below(2) == 0 ? RepairMethod::cavity
                                                       : RepairMethod::extension;
                 const auto first = must(validate(b.mesh, before, options.min_scaled_jacobian, alone)).validation();
                 const auto r = repaired(b, before, options);
                 const Proposal<D>& after = r.judged.proposal();
                 const auto again = must(validate(b.mesh, after, options.min_scaled_jacobian, alone)).validation();
                 RC_ASSERT(again == r.judged.validation());
                 std::size_t corrected = 0, moved = 0, surface = 0, vertices = 0;
                 for (std::size_t e = 0; e < again.verdicts.size(); ++e) {
                     if (first.verdicts[e] == Verdict::valid) RC_ASSERT(again.verdicts[e] == Verdict::valid);
                     corrected += first.verdicts[e] != Verdict::valid && again.verdicts[e] == Verdict::valid;
                 }
                 for (std::size_t e = 0; e < b.kinds.size(); ++e) {
                     if (after.mid_nodes[e] == before.mid_nodes[e]) {
                         RC_ASSERT(after.changes[e] == before.changes[e]);
                         continue;
                     }
                     ++(b.kinds[e] == EdgeKind::volume ? moved : surface);
                 }
                 for (std::size_t v = 0; v < b.mesh.linear.points.size(); ++v)
                     vertices += after.points[v] != b.mesh.linear.points[v];
                 RC_ASSERT(r.statistics.corrected_elements == corrected);
                 RC_ASSERT(r.statistics.moved_volume_nodes == moved);
                 RC_ASSERT(r.statistics.moved_surface_nodes == surface);
                 RC_ASSERT(r.statistics.moved_vertices == vertices);
                 if (options.method == RepairMethod::edge)
                     RC_ASSERT(surface == 0 && vertices == 0);
                 else
                     RC_ASSERT(again.all_valid());
             },
             {D == 2 ? 10 : 3});
}

template <int D>
void loses_less(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 3);
    const auto wanted = thrown(b, 4, 0.2);
    RepairOptions theta;
    theta.method = RepairMethod::backtracking;
    theta.min_scaled_jacobian = 0.05;
    const auto judged = must(validate(b.mesh, wanted, 0.05, alone));
    CHECK(judged.validation().invalid > 0);
    const auto relaxed = must(relax(judged, theta, alone));
    RepairOptions options;
    options.min_scaled_jacobian = 0.05;
    const auto mended = repaired(b, wanted, options);
    CHECK(mended.judged.validation().all_valid());
    CHECK(mended.statistics.moved_surface_nodes == 0);
    CHECK(cost(b, wanted, mended.judged.proposal()) < cost(b, wanted, relaxed.judged.proposal()));
}

template <int D>
void threads(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 5);
    const auto p = thrown(b, 6, 0.15);
    RepairOptions options;
    options.min_scaled_jacobian = 0.1;
    const auto one = repaired(b, p, options, 1);
    for (const int n : {2, 5}) {
        const auto several = repaired(b, p, options, n);
        CHECK(several.judged == one.judged);
    }
}

/// Of a request that cannot be had: nothing that was good is lost, no more work is done than allowed, what was given up
/// is what is left, progress never falls, and threads change nothing.
template <int D>
void work_has_bounds(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 8);
    const auto p = thrown(b, 9, 0.4);
    RepairOptions options;
    options.min_scaled_jacobian = 0.999;
    const auto before = must(validate(b.mesh, p, options.min_scaled_jacobian, alone)).validation();
    for (const double effort : {0.0, 0.05, 5.0}) {
        CAPTURE(effort);
        options.effort = effort;
        const auto r = repaired(b, p, options);
        const Validation<D>& after = r.judged.validation();
        // Programmes of single edges are not cut short: twelve a plan at most, 32 plans at once.
        CHECK(r.statistics.work <= allowed_work(before.not_valid(), effort) + (effort > 0 ? 384 : 0));
        CHECK(after.not_valid() <= before.not_valid());
        CHECK(r.given_up.size() == after.not_valid());
        CHECK(repaired(b, p, options, 3).judged == r.judged);
    }
    std::vector<double> told;
    const auto judged = must(validate(b.mesh, p, options.min_scaled_jacobian, alone));
    const Execution listening{1, {}, [&](std::size_t done, std::size_t total) {
                                  if (total >= 1000)
                                      told.push_back(static_cast<double>(done) / static_cast<double>(total));
                              }};
    CHECK(repair(judged, guide_of(b, p), options, listening).has_value());
    CHECK(told.size() >= 3);
    CHECK(std::ranges::is_sorted(told));
    CHECK((told.empty() || told.back() <= 1));
}

/// Where home holds the target it is always reached, without any work: what is not good enough, and what breaks by its
/// steps, goes there at the most; nodes that are around neither stay.
template <int D>
void goes_home(const std::array<int, D>& cells) {
    property("what is not good enough goes home",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 Dice dice(seed);
                 auto home = must(extend_boundary(b.mesh, b.kinds, b.boundary_nodes, b.shells, {}, alone));
                 const Column<LagrangeNode<D>> extended(std::move(home.nodes));
                 RepairOptions options;
                 options.effort = 0;
                 options.restore_effort = 0;
                 options.min_scaled_jacobian = dice.below(2) == 0 ? 1e-9 : 0.1;
                 Proposal<D> p = thrown(b, seed + 2, dice.uniform(0.1, 0.4));
                 Proposal<D> at_home = p;
                 at_home.mid_nodes = extended;
                 if (!must(validate(b.mesh, at_home, 0.1, alone)).validation().all_valid()) return;
                 RepairGuide<D> guide = guide_of(b, p);
                 guide.home = extended;
                 const auto judged = must(validate(b.mesh, p, options.min_scaled_jacobian, alone));
                 const auto r = must(repair(judged, guide, options, alone));
                 RC_ASSERT(r.judged.validation().all_valid());
                 RC_ASSERT(r.statistics.work == 0);
                 RC_ASSERT(r.statistics.moved_surface_nodes + r.statistics.moved_vertices == 0);
                 const auto& nodes = r.judged.proposal().mid_nodes;
                 for (std::size_t e = 0; e < nodes.size(); ++e) {
                     // On the segment from its place home.
                     const double way = distance(p.mid_nodes[e].point, extended[e].point);
                     const double first = distance(p.mid_nodes[e].point, nodes[e].point);
                     const double rest = distance(nodes[e].point, extended[e].point);
                     RC_ASSERT(std::abs(first + rest - way) <= 1e-9 * (1 + way));
                 }
                 RC_ASSERT(must(repair(judged, guide, options, Execution{3})).judged == r.judged);
             },
             {D == 2 ? 10 : 4});
}

/// The mean natural metric of the elements around an edge.
template <int D>
LogMetric<D> mean_natural(const Block<D>& b, EdgeId edge) {
    LogMetric<D> mean;
    for (const ElementId e : b.shells[edge])
        mean.l += natural_log_metric<D>(corners(b.mesh.linear, b.mesh.linear.points, e.index())).l;
    mean.l *= 1.0 / static_cast<double>(b.shells[edge].size());
    return mean;
}

/// About a straight edge: across it a model in a constant metric agrees with the length that is lost; without a field
/// it is the energy's second order, half of the energy's share, in the mean natural metric; along the edge a twentieth
/// of the energy's.
template <int D>
void models_agree(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 7);
    LogMetric<D> constant;
    for (int i = 0; i < D; ++i) constant.l(i, i) = 0.5 * i;
    constant.l(1, 0) = 0.3;
    const auto around = must(balls(b.mesh.linear, alone));
    const auto back =
        must(make_back_mesh(b.mesh.linear, around,
                            Column<LogMetric<D>>(Buffer<LogMetric<D>>(b.mesh.linear.points.size(), constant)), alone));
    const auto fitted = edge_models(CurvingAim::energy, b.mesh, b.mesh.mid_nodes, b.shells, back);
    const auto implied = implied_edge_models(b.mesh, b.mesh.mid_nodes, b.shells);
    const Quadrature rule = gauss_legendre(12);
    const SpectralMetric<D> metric(constant);
    for (std::size_t e = 0; e < b.mesh.edges.size(); e += 7) {
        const auto [p, q] = b.mesh.edges.vertices[e];
        const Vec<D> chord = b.mesh.linear.points[q] - b.mesh.linear.points[p];
        const Vec<D> middle = b.mesh.mid_nodes[e].point;
        const auto share = [&](EdgeObjectiveKind kind, const Vec<D>& offset) {
            const auto objective =
                edge_objective(back, rule, kind, EdgeFieldKind::back,
                               {b.mesh.linear.points[p], b.mesh.linear.points[q], b.shells[e].front()});
            return objective.value(middle + offset) / objective.value(middle) - 1;
        };
        Vec<D> offset;
        for (int i = 0; i < D; ++i) offset[i] = 0.01 * (i + 1);
        const Vec<D> along = dot(offset, metric.times(chord)) / metric.length_squared(chord) * chord;
        const Vec<D> across = offset - along;
        const double slide = 0.05 * 0.5 * share(EdgeObjectiveKind::energy, along);
        const double small = 0.01 / std::sqrt(metric.length_squared(across) / metric.length_squared(chord));
        const QuadraticModel<D> model = fitted(EdgeId(e));
        CHECK(model(middle + small * across) ==
              doctest::Approx(share(EdgeObjectiveKind::length, small * across)).epsilon(1e-2));
        CHECK(model(middle + along) == doctest::Approx(slide).epsilon(1e-6));
        const QuadraticModel<D> natural = implied(EdgeId(e));
        const SpectralMetric<D> mean(mean_natural(b, EdgeId(e)));
        const double unit = mean.length_squared(chord);
        const Vec<D> slid = dot(offset, mean.times(chord)) / unit * chord;
        CHECK(natural(middle + slid) ==
              doctest::Approx(0.05 * 8.0 / 3 * mean.length_squared(slid) / unit).epsilon(1e-9));
        CHECK(natural(middle + offset) - natural(middle + slid) ==
              doctest::Approx(8.0 / 3 * mean.length_squared(offset - slid) / unit).epsilon(1e-9));
    }
}

/// Thin layers that bend by 0.6 radians a cell: elements with an edge on the outer side of a layer are inverted when
/// straight, and valid with their nodes on the arcs.
template <int D>
QuadraticMesh<D> bent_layers(std::uint64_t seed, double thickness) {
    LatticeOptions<D> options;
    options.cells.fill(2);
    options.cells[0] = 4;
    options.cells[1] = 3;
    options.seed = seed;
    const LinearMesh<D> flat = lattice_mesh(options);
    const auto bent = [&](Vec<D> p) {
        const double radius = 1 + thickness * p[1], angle = 0.6 * (p[0] + 0.5 * p[1]);
        p[0] = radius * std::sin(angle);
        p[1] = radius * std::cos(angle);
        return p;
    };
    LinearMesh<D> linear = flat;
    Buffer<Vec<D>> points(flat.points.begin(), flat.points.end());
    for (Vec<D>& p : points) p = bent(p);
    linear.points = std::move(points);
    QuadraticMesh<D> mesh = must(elevate(std::move(linear), alone));
    Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        nodes[e] = {bent(midpoint(flat.points[a], flat.points[b]))};
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

/// Some of the nodes thrown about by shares of their chords.
template <int D>
Column<LagrangeNode<D>> some_thrown(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, Dice& dice,
                                    double share, double amplitude) {
    Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const double by = (kinds[e] == EdgeKind::volume ? 1 : 0.2) * amplitude;
        if (dice.uniform(0, 1) < share)
            nodes[e].point += by * distance(mesh.linear.points[a], mesh.linear.points[b]) * dice.vector<D>(-1, 1);
    }
    return nodes;
}

template <int D>
void never_more_invalid() {
    std::size_t inverted = 0, damaged = 0, restored = 0;
    property("repair leaves no more invalid elements than the input has",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 QuadraticMesh<D> mesh = bent_layers<D>(seed + 1, dice.uniform(0.02, 0.04));
                 const auto kinds = boundary_kinds(mesh.linear, mesh.edges);
                 const auto around = must(shells(mesh.edges, alone));
                 REQUIRE(must(validate(mesh, min_bound, alone)).all_valid());
                 const bool is_damaged = dice.below(3) == 0;
                 if (is_damaged) mesh.mid_nodes = some_thrown(mesh, kinds, dice, 0.1, 0.3);
                 const bool is_own = is_damaged && dice.below(2) == 0;
                 const Proposal<D> proposal{mesh.linear.points,
                                            is_own ? mesh.mid_nodes : some_thrown(mesh, kinds, dice, 0.3, 0.3), kinds,
                                            Buffer<EdgeChange>(mesh.edges.size(), EdgeChange::optimised)};
                 RepairOptions options;
                 if (dice.below(2) == 0) options.min_scaled_jacobian = min_bound;
                 const auto judged = must(validate(mesh, proposal, options.min_scaled_jacobian, alone));
                 const auto input = must(validate(mesh, min_bound, alone));
                 inverted += input.straight_inverted;
                 damaged += input.not_valid();
                 const auto expect_no_more = [&](const Repaired<D>& r) {
                     const auto after = must(validate(mesh, r.judged.proposal(), min_bound, alone)).validation();
                     RC_ASSERT(after.not_valid() <= input.not_valid());
                     const double bound = r.judged.validation().bound;
                     RC_ASSERT(r.judged.validation() ==
                               must(validate(mesh, r.judged.proposal(), bound, alone)).validation());
                     for (std::size_t e = 0; e < mesh.edges.size(); ++e)
                         restored += r.judged.proposal().mid_nodes[e] == mesh.mid_nodes[e] &&
                                     proposal.mid_nodes[e] != mesh.mid_nodes[e];
                 };
                 for (const auto method : {RepairMethod::extension, RepairMethod::cavity, RepairMethod::edge,
                                           RepairMethod::segment, RepairMethod::backtracking}) {
                     options.method = method;
                     options.effort = dice.below(2) == 0 ? 0.02 : 1;
                     const auto guide =
                         needs_models(method) ? must(own_guide(judged, around, alone)) : RepairGuide<D>{};
                     expect_no_more(must(repair_or_straighten(judged, guide, options, alone)));
                     expect_no_more(must(repair_within(judged, guide, options, alone)));
                     if (!needs_models(method)) expect_no_more(must(relax(judged, options, alone)));
                 }
             },
             {D == 2 ? 10 : 2});
    CHECK(inverted > 0);
    CHECK(damaged > 0);
    CHECK(restored > 0);
}

}  // namespace

TEST_CASE("repair: never more invalid elements than the input, though straight elements are inverted") {
    never_more_invalid<2>();
    never_more_invalid<3>();
}
TEST_CASE("elements are raised to the target, and none that was valid ends lower, 2D") { raised<2>({8, 5}); }
TEST_CASE("elements are raised to the target, and none that was valid ends lower, 3D") { raised<3>({3, 3, 3}); }
TEST_CASE("repair: laws, 2D") { laws<2>({8, 5}); }
TEST_CASE("repair: laws, 3D") { laws<3>({3, 3, 3}); }
TEST_CASE("repair: vertices that move") {
    vertices_that_move<2>({5, 4});
    vertices_that_move<3>({3, 2, 2});
}
TEST_CASE("repair: cavities lose less than relaxing by theta") {
    loses_less<2>({16, 8});
    loses_less<3>({4, 4, 3});
}
TEST_CASE("repair: the same bytes for any number of threads") {
    threads<2>({16, 8});
    threads<3>({3, 3, 3});
}
TEST_CASE("repair: home") {
    goes_home<2>({10, 5});
    goes_home<3>({3, 3, 3});
}
// Guards against repair without end, and progress that falls from 100 % to 20 %.
TEST_CASE("repair: work has bounds") {
    work_has_bounds<2>({12, 8});
    work_has_bounds<3>({3, 3, 3});
}
TEST_CASE("repair: models agree with what is lost") {
    models_agree<2>({6, 4});
    models_agree<3>({3, 3, 3});
}
TEST_CASE("repair: what cannot be is said") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto p = thrown(b, 2, 0.1);
    const auto judged = must(validate(b.mesh, p, 0, alone));
    const auto guide = guide_of(b, p);
    RepairOptions options;
    options.min_scaled_jacobian = 1;
    CHECK(repair(judged, guide, options, alone).error().kind == ErrorKind::usage);
    options = {};
    options.target = -1;
    CHECK(repair(judged, guide, options, alone).error().kind == ErrorKind::usage);
    options = {};
    options.effort = -1;
    CHECK(repair(judged, guide, options, alone).error().kind == ErrorKind::usage);
    std::stop_source stop;
    stop.request_stop();
    const auto bad = thrown(b, 2, 0.5);
    CHECK(repair(must(validate(b.mesh, bad, 1e-12, alone)), {}, {}, alone).error().kind == ErrorKind::internal);
    CHECK(repair(must(validate(b.mesh, bad, 1e-12, alone)), guide_of(b, bad), {}, Execution{1, stop.get_token(), {}})
              .error()
              .kind == ErrorKind::stopped);
}
