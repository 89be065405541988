// Number of points per edge at which curving samples the background mesh. Each sample is a point location, which
// dominates the cost of a search.
#include <cstddef>
#include <span>
#include <utility>

#include <doctest/doctest.h>

#include "shell.hpp"

import camber.core;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

/// Background mesh that counts its samples.
class CountingBack final : public BackModel<3> {
  public:
    CountingBack(BackMesh<3> back, std::size_t& points) : back_(std::move(back)), points_(&points) {}

    [[nodiscard]] Location<3> locate(const Vec<3>& p, ElementId hint) const override {
        ++*points_;
        return back_->locate(p, hint);
    }
    void sample_values(std::span<const Vec<3>> points, ElementId hint, std::span<FieldSample<3>> out) const override {
        *points_ += points.size();
        back_->sample_values(points, hint, out);
    }
    void sample_with_gradients(std::span<const Vec<3>> points, ElementId hint,
                               std::span<FieldSample<3>> out) const override {
        *points_ += points.size();
        back_->sample_with_gradients(points, hint, out);
    }
    void sample_with_recovered_gradients(std::span<const Vec<3>> points, ElementId hint,
                                         std::span<FieldSample<3>> out) const override {
        *points_ += points.size();
        back_->sample_with_recovered_gradients(points, hint, out);
    }
    void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const override {
        back_->sample_edges(edges, out);
    }
    [[nodiscard]] std::size_t vertex_count() const override { return back_->vertex_count(); }
    [[nodiscard]] BackVertex<3> vertex(VertexId v) const override { return back_->vertex(v); }
    [[nodiscard]] BackSector<3> sector(ElementId e, VertexId a, VertexId b) const override {
        return back_->sector(e, a, b);
    }

  private:
    BackMesh<3> back_;
    std::size_t* points_;
};

/// Samples per volume edge for the placement of its node, with one thread and without the lengths of the report.
double points_per_edge(const ShellCase& c, CurvingAim aim) {
    CurveOptions options;
    options.aim = aim;
    const EdgeRules rules = edge_rules(options);
    std::size_t points = 0, edges = 0;
    const BackMesh<3> back(CountingBack(c.back, points));
    for (std::size_t e = 0; e < c.edges(); e += 20) {
        if (c.kinds[e] != EdgeKind::volume) continue;
        const EdgeId edge(e);
        const auto& [a, b] = c.mesh.edges.vertices[edge];
        (void)minimise_back_edge(back, {a, b, c.shell[edge]}, c.mesh.mid_nodes[edge], rules, search_options(options));
        ++edges;
    }
    return static_cast<double>(points) / static_cast<double>(edges);
}

}  // namespace

TEST_CASE("curving samples the background mesh at few points per edge") {
    const ShellCase c;
    SUBCASE("objective accuracy samples no point") {
        std::size_t points = 0;
        const BackMesh<3> back(CountingBack(c.back, points));
        (void)must(
            accurate_offsets({c.mesh, c.kinds, c.shell}, EdgeKind::volume, back, EdgeAccuracyOptions{}, one_thread));
        CHECK(points == 0);
    }
    SUBCASE("searches for energy and length sample at most 160 and 134 points per edge") {
        CHECK(points_per_edge(c, CurvingAim::energy) < 160);  // 138 when the bound was set
        CHECK(points_per_edge(c, CurvingAim::length) < 134);  // 116 when the bound was set
    }
}
