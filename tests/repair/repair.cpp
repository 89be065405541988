// Repair corrects invalid elements at a small cost and does not damage others.
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

/// The block with its boundary on the spheres and volume nodes displaced by up to `amplitude` chords.
template <int D>
Proposal<D> displaced_nodes(const Block<D>& b, std::uint64_t seed, double amplitude) {
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
    const auto judged = must(validate(b.mesh, p, options.min_scaled_jacobian, one_thread));
    return must(repair(judged, guide_of(b, p), options, Execution{threads}));
}

/// The cost of the nodes by the models, summed over the volume edges.
template <int D>
double cost(const Block<D>& b, const Proposal<D>& proposal, const Proposal<D>& result) {
    const auto guide = guide_of(b, proposal);
    double sum = 0;
    for (std::size_t e = 0; e < b.kinds.size(); ++e)
        if (b.kinds[e] == EdgeKind::volume) sum += guide.models(EdgeId(e))(result.mid_nodes[e].point);
    return sum;
}

template <int D>
std::array<Vec<D>, D + 1> corners(const LinearMesh<D>& mesh, const Column<Vec<D>>& points, std::size_t e) {
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[static_cast<std::size_t>(i)] = points[mesh.elements.vertices[e][i]];
    return p;
}

/// A volume vertex is moved to the other side of its ball. After repair the elements around moved vertices hold the
/// bound with respect to their former determinants, and keep a minimum mean ratio.
template <int D>
void check_moved_vertices(const std::array<int, D>& cells) {
    std::size_t moves = 0;
    // Guards against a repaired vertex that leaves a sliver.
    property("moved vertices preserve the mean ratio and the Jacobian of valid elements",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 auto b = shell_block<D>(cells, seed + 1);
                 auto points = take(b.mesh.linear.points);
                 const auto on = boundary_marks(b);
                 for (std::size_t v = 0; v < points.size(); ++v)
                     if (on[v] == 0 && dice.below(3) == 0) points[v] += dice.vector<D>(-1, 1);
                 b.mesh.linear.points = std::move(points);
                 b.mesh = must(elevate(b.mesh.linear, one_thread));
                 const LinearMesh<D>& mesh = b.mesh.linear;
                 RepairOptions options;
                 options.min_scaled_jacobian = dice.below(2) == 0 ? 1e-9 : 0.2;
                 const auto straight = must(curve_boundary(b.mesh, b.kinds, b.mesh.mid_nodes, one_thread)).proposal;
                 const auto judged = must(validate(b.mesh, straight, options.min_scaled_jacobian, one_thread));
                 const RepairGuide<D> guide{b.shells, [nodes = b.mesh.mid_nodes](EdgeId e) { return nodes[e]; },
                                            implied_edge_models(b.mesh, b.mesh.mid_nodes, b.shells)};
                 const auto r = must(repair(judged, guide, options, one_thread));
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

/// Compares a repair to the default bound with one that raises elements to a higher target.
template <int D>
void check_raised(const std::array<int, D>& cells) {
    std::size_t gained = 0;
    property("a target raises elements above the bound and lowers no valid one",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto proposal = displaced_nodes(b, seed + 2, dice.uniform(0.05, 0.3));
                 RepairOptions options;
                 if (dice.below(2) == 0) options.min_scaled_jacobian = dice.uniform(0.05, 0.25);
                 const auto to_bound = [&](double target, int threads) {
                     options.target = target;
                     const auto judged = must(validate(b.mesh, proposal, options.min_scaled_jacobian, one_thread));
                     return must(repair_or_straighten(judged, guide_of(b, proposal), options, Execution{threads}));
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
                 std::size_t certainly = 0, perhaps = 0;  // values are certified to 1e-3
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
void check_repair(const std::array<int, D>& cells) {
    property("repair keeps valid elements and boundary nodes, and its statistics are correct",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto before = displaced_nodes(b, seed + 2, dice.uniform(0.1, 0.4));
                 RepairOptions options;
                 options.min_scaled_jacobian = dice.below(2) == 0 ? 1e-12 : 0.1;
                 options.method = dice.below(4) == 0   ? RepairMethod::edge
                                  : dice.below(2) == 0 ? RepairMethod::cavity
                                                       : RepairMethod::extension;
                 const auto first =
                     must(validate(b.mesh, before, options.min_scaled_jacobian, one_thread)).validation();
                 const auto r = repaired(b, before, options);
                 const Proposal<D>& after = r.judged.proposal();
                 const auto again = must(validate(b.mesh, after, options.min_scaled_jacobian, one_thread)).validation();
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
void check_cost(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 3);
    const auto proposal = displaced_nodes(b, 4, 0.2);
    RepairOptions theta;
    theta.method = RepairMethod::backtracking;
    theta.min_scaled_jacobian = 0.05;
    const auto judged = must(validate(b.mesh, proposal, 0.05, one_thread));
    CHECK(judged.validation().invalid > 0);
    const auto relaxed = must(relax(judged, theta, one_thread));
    RepairOptions options;
    options.min_scaled_jacobian = 0.05;
    const auto by_cavities = repaired(b, proposal, options);
    CHECK(by_cavities.judged.validation().all_valid());
    CHECK(by_cavities.statistics.moved_surface_nodes == 0);
    CHECK(cost(b, proposal, by_cavities.judged.proposal()) < cost(b, proposal, relaxed.judged.proposal()));
}

template <int D>
void check_threads(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 5);
    const auto p = displaced_nodes(b, 6, 0.15);
    RepairOptions options;
    options.min_scaled_jacobian = 0.1;
    const auto one = repaired(b, p, options, 1);
    for (const int n : {2, 5}) {
        const auto several = repaired(b, p, options, n);
        CHECK(several.judged == one.judged);
    }
}

/// An unreachable target: valid elements stay valid, work stays within its limit, the remaining invalid elements are
/// reported, progress never decreases, and threads have no effect.
template <int D>
void check_work(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 8);
    const auto p = displaced_nodes(b, 9, 0.4);
    RepairOptions options;
    options.min_scaled_jacobian = 0.999;
    const auto before = must(validate(b.mesh, p, options.min_scaled_jacobian, one_thread)).validation();
    for (const double effort : {0.0, 0.05, 5.0}) {
        CAPTURE(effort);
        options.effort = effort;
        const auto r = repaired(b, p, options);
        const Validation<D>& after = r.judged.validation();
        // Programs of single edges are not interrupted: at most 12 a plan, 32 plans at once.
        CHECK(r.statistics.work <= allowed_work(before.not_valid(), effort) + (effort > 0 ? 384 : 0));
        CHECK(after.not_valid() <= before.not_valid());
        CHECK(r.unresolved.size() == after.not_valid());
        CHECK(repaired(b, p, options, 3).judged == r.judged);
    }
    std::vector<double> progress;
    const auto judged = must(validate(b.mesh, p, options.min_scaled_jacobian, one_thread));
    const Execution listening{1, {}, [&](std::size_t done, std::size_t total) {
                                  if (total >= 1000)
                                      progress.push_back(static_cast<double>(done) / static_cast<double>(total));
                              }};
    CHECK(repair(judged, guide_of(b, p), options, listening).has_value());
    CHECK(progress.size() >= 3);
    CHECK(std::ranges::is_sorted(progress));
    CHECK((progress.empty() || progress.back() <= 1));
}

/// If the target positions satisfy the bound, they are reached without further work. Nodes move at most to their target
/// positions, and nodes of other elements stay.
template <int D>
void check_restored_nodes(const std::array<int, D>& cells) {
    property("repair moves nodes of invalid elements towards their target positions",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 Dice dice(seed);
                 auto extension = must(extend_boundary(b.mesh, b.kinds, b.boundary_nodes, b.shells, {}, one_thread));
                 const Column<LagrangeNode<D>> extended(std::move(extension.nodes));
                 RepairOptions options;
                 options.effort = 0;
                 options.restore_effort = 0;
                 options.min_scaled_jacobian = dice.below(2) == 0 ? 1e-9 : 0.1;
                 Proposal<D> p = displaced_nodes(b, seed + 2, dice.uniform(0.1, 0.4));
                 Proposal<D> at_targets = p;
                 at_targets.mid_nodes = extended;
                 if (!must(validate(b.mesh, at_targets, 0.1, one_thread)).validation().all_valid()) return;
                 RepairGuide<D> guide = guide_of(b, p);
                 guide.global_extension = extended;
                 const auto judged = must(validate(b.mesh, p, options.min_scaled_jacobian, one_thread));
                 const auto r = must(repair(judged, guide, options, one_thread));
                 RC_ASSERT(r.judged.validation().all_valid());
                 RC_ASSERT(r.statistics.work == 0);
                 RC_ASSERT(r.statistics.moved_surface_nodes + r.statistics.moved_vertices == 0);
                 const auto& nodes = r.judged.proposal().mid_nodes;
                 for (std::size_t e = 0; e < nodes.size(); ++e) {
                     // The node is on the segment to its target position.
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

/// Models of a straight edge. Across the edge a model in a constant metric agrees with the increase of length; without
/// a field it is half of the second-order increase of energy in the mean natural metric. Along the edge it is a
/// twentieth of the increase of energy.
template <int D>
void check_models(const std::array<int, D>& cells) {
    const auto b = shell_block<D>(cells, 7);
    LogMetric<D> constant;
    for (int i = 0; i < D; ++i) constant.l(i, i) = 0.5 * i;
    constant.l(1, 0) = 0.3;
    const auto around = must(balls(b.mesh.linear, one_thread));
    const auto back = must(
        make_back_mesh(b.mesh.linear, around,
                       Column<LogMetric<D>>(Buffer<LogMetric<D>>(b.mesh.linear.points.size(), constant)), one_thread));
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

/// Thin layers that bend by 0.6 radians a cell. Elements with an edge on the outer side of a layer are inverted when
/// straight, and valid with nodes on the arcs.
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
    QuadraticMesh<D> mesh = must(elevate(std::move(linear), one_thread));
    Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        nodes[e] = {bent(midpoint(flat.points[a], flat.points[b]))};
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

/// Displaces some of the nodes by shares of their chords.
template <int D>
Column<LagrangeNode<D>> some_displaced(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, Dice& dice,
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
void check_invalid_count() {
    std::size_t inverted = 0, damaged = 0, restored = 0;
    property("repair leaves no more invalid elements than the input has",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 QuadraticMesh<D> mesh = bent_layers<D>(seed + 1, dice.uniform(0.02, 0.04));
                 const auto kinds = boundary_kinds(mesh.linear, mesh.edges);
                 const auto around = must(shells(mesh.edges, one_thread));
                 REQUIRE(must(validate(mesh, min_bound, one_thread)).all_valid());
                 const bool is_damaged = dice.below(3) == 0;
                 if (is_damaged) mesh.mid_nodes = some_displaced(mesh, kinds, dice, 0.1, 0.3);
                 const bool is_own = is_damaged && dice.below(2) == 0;
                 const Proposal<D> proposal{mesh.linear.points,
                                            is_own ? mesh.mid_nodes : some_displaced(mesh, kinds, dice, 0.3, 0.3),
                                            kinds, Buffer<EdgeChange>(mesh.edges.size(), EdgeChange::optimised)};
                 RepairOptions options;
                 if (dice.below(2) == 0) options.min_scaled_jacobian = min_bound;
                 const auto judged = must(validate(mesh, proposal, options.min_scaled_jacobian, one_thread));
                 const auto input = must(validate(mesh, min_bound, one_thread));
                 inverted += input.straight_inverted;
                 damaged += input.not_valid();
                 const auto expect_no_more = [&](const Repaired<D>& r) {
                     const auto after = must(validate(mesh, r.judged.proposal(), min_bound, one_thread)).validation();
                     RC_ASSERT(after.not_valid() <= input.not_valid());
                     const double bound = r.judged.validation().bound;
                     RC_ASSERT(r.judged.validation() ==
                               must(validate(mesh, r.judged.proposal(), bound, one_thread)).validation());
                     for (std::size_t e = 0; e < mesh.edges.size(); ++e)
                         restored += r.judged.proposal().mid_nodes[e] == mesh.mid_nodes[e] &&
                                     proposal.mid_nodes[e] != mesh.mid_nodes[e];
                 };
                 for (const auto method : {RepairMethod::extension, RepairMethod::cavity, RepairMethod::edge,
                                           RepairMethod::segment, RepairMethod::backtracking}) {
                     options.method = method;
                     options.effort = dice.below(2) == 0 ? 0.02 : 1;
                     const auto guide =
                         needs_models(method) ? must(guide_from_mesh(judged, around, one_thread)) : RepairGuide<D>{};
                     expect_no_more(must(repair_or_straighten(judged, guide, options, one_thread)));
                     expect_no_more(must(repair_within(judged, guide, options, one_thread)));
                     if (!needs_models(method)) expect_no_more(must(relax(judged, options, one_thread)));
                 }
             },
             {D == 2 ? 10 : 2});
    CHECK(inverted > 0);
    CHECK(damaged > 0);
    CHECK(restored > 0);
}

}  // namespace

TEST_CASE("repair leaves no more invalid elements than the input with inverted straight elements") {
    check_invalid_count<2>();
    check_invalid_count<3>();
}
TEST_CASE("repair raises elements to the target and lowers no valid one, 2D") { check_raised<2>({8, 5}); }
TEST_CASE("repair raises elements to the target and lowers no valid one, 3D") { check_raised<3>({3, 3, 3}); }
TEST_CASE("repair corrects elements, keeps valid ones and reports its changes, 2D") { check_repair<2>({8, 5}); }
TEST_CASE("repair corrects elements, keeps valid ones and reports its changes, 3D") { check_repair<3>({3, 3, 3}); }
TEST_CASE("moved vertices keep the Jacobian bound and the mean ratio of their elements") {
    check_moved_vertices<2>({5, 4});
    check_moved_vertices<3>({3, 2, 2});
}
TEST_CASE("cavity repair costs less than relaxation by backtracking") {
    check_cost<2>({16, 8});
    check_cost<3>({4, 4, 3});
}
TEST_CASE("repair does not depend on the number of threads") {
    check_threads<2>({16, 8});
    check_threads<3>({3, 3, 3});
}
TEST_CASE("repair moves nodes towards valid target positions without further work") {
    check_restored_nodes<2>({10, 5});
    check_restored_nodes<3>({3, 3, 3});
}
// Guards against repair without end, and progress that falls from 100 % to 20 %.
TEST_CASE("repair keeps its work limit and reports rising progress") {
    check_work<2>({12, 8});
    check_work<3>({3, 3, 3});
}
TEST_CASE("edge models agree with the increase of length and energy") {
    check_models<2>({6, 4});
    check_models<3>({3, 3, 3});
}
TEST_CASE("repair rejects options out of range") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto p = displaced_nodes(b, 2, 0.1);
    const auto judged = must(validate(b.mesh, p, 0, one_thread));
    const auto guide = guide_of(b, p);
    RepairOptions options;
    options.min_scaled_jacobian = 1;
    CHECK(repair(judged, guide, options, one_thread).error().kind == ErrorKind::usage);
    options = {};
    options.target = -1;
    CHECK(repair(judged, guide, options, one_thread).error().kind == ErrorKind::usage);
    options = {};
    options.effort = -1;
    CHECK(repair(judged, guide, options, one_thread).error().kind == ErrorKind::usage);
}

TEST_CASE("repair rejects an empty guide") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto bad = displaced_nodes(b, 2, 0.5);
    CHECK(repair(must(validate(b.mesh, bad, 1e-12, one_thread)), {}, {}, one_thread).error().kind ==
          ErrorKind::internal);
}

TEST_CASE("repair stops on request") {
    const auto b = shell_block<2>({4, 3}, 1);
    const auto bad = displaced_nodes(b, 2, 0.5);
    std::stop_source stop;
    stop.request_stop();
    CHECK(
        repair(must(validate(b.mesh, bad, 1e-12, one_thread)), guide_of(b, bad), {}, Execution{1, stop.get_token(), {}})
            .error()
            .kind == ErrorKind::stopped);
}
