// Remeshes a domain with all passes to alternately coarser and finer metrics and checks its invariants. Guards against
// passes that lower the worst quality repeatedly.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "goals.hpp"
#include "mesh_invariants.hpp"
#include "meshes.hpp"
#include "named_domains.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// Results of a round.
struct Round {
    double size = 0;  ///< size requested by the metric, relative to that of the first mesh
    std::size_t vertices = 0, elements = 0;
    std::array<PassStatistics, 4> passes;  ///< collapse, split, swap, smooth
    double flat = 0, curved = 0;           ///< maximum relative deviation of flat and of curved measures
    std::size_t off = 0;                   ///< vertices off their surface
    double unit_share = 0, worst_quality = 0;
};

/// Maximum relative deviation of curved measures from their formulas, relative to the square of the cell size of the
/// first mesh. Facets are up to 1.6 times as large as cells, and larger where the requested size grows.
inline constexpr double max_curved_deviation = 0.6;

template <int D>
class ManyRounds {
  public:
    ManyRounds(NamedDomain<D> domain, std::uint64_t seed, Execution execution)
        : domain_(with_required(std::move(domain), seed)),
          dice_(seed),
          execution_(execution),
          mesh_(initial_mesh()),
          invariants_(invariants_of(mesh_)) {
        for (const auto& [key, value] : domain_.curved) invariants_.sizes.erase(key);
    }
    [[nodiscard]] const DynamicMesh<D>& mesh() const { return mesh_; }

    /// Returns the violated property, or an empty string.
    [[nodiscard]] std::string run(double size, Round& round) {
        round.size = size;
        goal_ = goal_over(domain_.mesh, size * domain_.cell, dice_);
        if (!domain_.surfaces.surfaces.empty()) goal_.geometry = Geometry<D>(domain_.surfaces);
        Adaptation<D> r = under_goal();
        worst_ = must(unit_mesh_statistics(r, execution_)).worst_quality;
        constexpr double bad = PatchLimits{}.bad_quality, bad_beside_long = 0.02;
        r = pass(collapse<D>(std::move(r), goal_, {}, execution_), bad, round.passes[0]);
        r = pass(split<D>(std::move(r), goal_, {}, execution_), bad_beside_long, round.passes[1]);
        r = pass(swap<D>(std::move(r), goal_, {}, execution_), bad, round.passes[2]);
        r = pass(smooth<D>(std::move(r), goal_, {}, execution_), bad, round.passes[3]);
        const UnitMeshStatistics unit = must(unit_mesh_statistics(r, execution_));
        round.unit_share = unit.unit_share();
        round.worst_quality = unit.worst_quality;
        mesh_ = std::move(r.mesh);
        round.vertices = mesh_.vertex_count();
        round.elements = mesh_.element_count();
        return round_violation(round);
    }

  private:
    /// Marks some entities of each kind as required.
    [[nodiscard]] static NamedDomain<D> with_required(NamedDomain<D> domain, std::uint64_t seed) {
        Dice dice(seed + 1);
        LinearMesh<D>& mesh = domain.mesh;
        const auto one_of = [&](std::size_t n) { return static_cast<std::uint32_t>(dice.below(n)); };
        mesh.required_vertices =
            Buffer<VertexId>{VertexId(one_of(mesh.points.size())), VertexId(one_of(mesh.points.size()))};
        mesh.facets.required = Buffer<std::uint32_t>{one_of(mesh.facets.size())};
        mesh.elements.required = Buffer<std::uint32_t>{one_of(mesh.elements.size())};
        return domain;
    }
    [[nodiscard]] DynamicMesh<D> initial_mesh() const {
        const auto edges = must(unique_edges(domain_.mesh, execution_));
        FeatureOptions<D> options;
        options.ridge_angle_degrees = domain_.ridge_angle_degrees;
        const auto features = must(find_features(domain_.mesh, edges, options, execution_));
        std::vector<VertexId> corners;
        for (std::size_t v = 0; v < domain_.mesh.points.size(); ++v)
            if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
        return must(make_dynamic(domain_.mesh, edges, {features.edge_kinds.view(), corners}, execution_));
    }
    [[nodiscard]] Adaptation<D> under_goal() {
        Buffer<VertexMetric<D>> metrics(mesh_.points.size());
        ElementId hint;
        for (std::size_t v = 0; v < metrics.size(); ++v) {
            if (mesh_.is_free(VertexId(v))) continue;
            const FieldSample<D> sample = sample_value(goal_.field, mesh_.points[v], hint);
            hint = sample.location.element;
            metrics[v] = {sample.log_metric, hint};
        }
        return {std::move(mesh_), {std::move(metrics)}};
    }
    [[nodiscard]] Adaptation<D> pass(Outcome<Adapted<D>> done, double bad_quality, PassStatistics& statistics) {
        Adapted<D> remeshed = must(std::move(done));
        statistics = remeshed.statistics;
        shortened_ += statistics.shortened;
        const double worst = must(unit_mesh_statistics(remeshed.state, execution_)).worst_quality;
        made_worse_ |= worst < (1 - 1e-8) * std::min(bad_quality, worst_);
        worst_ = worst;
        return std::move(remeshed.state);
    }

    [[nodiscard]] std::string round_violation(Round& round) {
        if (const std::string violation = topology_violation(mesh_, invariants_); !violation.empty()) return violation;
        if (made_worse_) return "a pass made a bad element worse";
        if (const std::string violation = orientation_violation(mesh_); !violation.empty()) return violation;
        const Sizes now = measures(mesh_);
        if (now.size() != invariants_.sizes.size() + domain_.curved.size()) return "a reference came or went";
        const auto deviate = [&](const Sizes& expected, double& most) {
            for (const auto& [key, value] : expected) {
                const auto at = now.find(key);
                most = std::max(most, at == now.end() ? 1 : std::abs(at->second / value - 1));
            }
        };
        deviate(invariants_.sizes, round.flat);
        deviate(domain_.curved, round.curved);
        if (!(round.flat < 1e-10)) return "what is flat has another size: " + largest_change(now);
        if (!(round.curved < max_curved_deviation * domain_.cell * domain_.cell || domain_.curved.empty()))
            return "what is curved has a size far from its geometry's";
        round.off = vertices_off();
        return round.off <= shortened_ ? "" : "vertices left their surface";
    }
    [[nodiscard]] std::string largest_change(const Sizes& now) const {
        std::string text;
        for (const auto& [key, value] : invariants_.sizes)
            if (const auto at = now.find(key); at == now.end() || std::abs(at->second / value - 1) > 1e-10)
                text += "dimension " + std::to_string(key.first) + ", reference " + std::to_string(key.second) + ": " +
                        std::to_string(at == now.end() ? 0 : at->second) + " for " + std::to_string(value) + "; ";
        return text;
    }
    [[nodiscard]] std::size_t vertices_off() const {
        std::vector<std::uint8_t> off(mesh_.points.size(), 0);
        for (std::size_t f = 0; f < mesh_.facets.size(); ++f) {
            if (mesh_.is_free(FacetId(f))) continue;
            const AnalyticSurface<D>* surface = surface_of(domain_.surfaces, mesh_.facets.references[f]);
            if (surface == nullptr) continue;
            for (const VertexId v : mesh_.facets.vertices[f])
                if (distance(closest_point(*surface, mesh_.points[v]).point, mesh_.points[v]) > 1e-9)
                    off[v.index()] = 1;
        }
        return static_cast<std::size_t>(std::ranges::count(off, 1));
    }

    NamedDomain<D> domain_;
    Dice dice_;
    Execution execution_;
    DynamicMesh<D> mesh_;
    Invariants<D> invariants_;
    AdaptationGoal<D> goal_;
    std::size_t shortened_ = 0;
    double worst_ = 1;  ///< quality after the last pass
    bool made_worse_ = false;
};

/// Size of a round relative to the size of the first mesh.
inline double size_of_round(int round) {
    constexpr std::array sizes{1.6, 0.7, 1.2, 0.8};
    return sizes[static_cast<std::size_t>(round) % sizes.size()];
}

}  // namespace camber::testing
