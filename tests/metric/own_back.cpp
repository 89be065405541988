// The back mesh interface: packs of points, and a curved back mesh implemented by the test.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>
#include <rapidcheck.h>

#include "back.hpp"
#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
bool same_bits(const FieldSample<D>& a, const FieldSample<D>& b) {
    bool same = a.location.element == b.location.element && a.location.xi == b.location.xi &&
                a.location.placement == b.location.placement && a.log_metric.l.c == b.log_metric.l.c;
    for (int i = 0; i < D; ++i) same = same && a.gradient[i].c == b.gradient[i].c;
    return same;
}

template <int D>
void check_packs() {
    property("a pack equals its points sampled in turn, to the last bit", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_back(unit_box<D>(3, seed + 1), dice);
        std::vector<Vec<D>> points(dice.below(15));
        for (Vec<D>& p : points) p = dice.vector<D>(-0.3, 1.3);
        const ElementId first(dice.below(back.mesh.elements.size()));
        std::vector<FieldSample<D>> values(points.size()), gradients(points.size()), recovered(points.size());
        back->sample_values(points, first, values);
        back->sample_with_gradients(points, first, gradients);
        back->sample_with_recovered_gradients(points, first, recovered);
        ElementId hint = first;
        for (std::size_t i = 0; i < points.size(); ++i) {
            RC_ASSERT(same_bits(values[i], sample_value(back, points[i], hint)));
            RC_ASSERT(same_bits(gradients[i], sample_with_gradient(back, points[i], hint)));
            RC_ASSERT(same_bits(recovered[i], sample_with_recovered_gradient(back, points[i], hint)));
            hint = values[i].location.element;
        }
    });
}

constexpr double h_radial = 0.05, h_tangential = 0.4;

/// An annulus between the radii 1 and 2 in curved cells, n along the radius and 4 n around, with the exact polar
/// metric; constant along the radius outside.
class CurvedCells final : public BackModel<2> {
  public:
    explicit CurvedCells(std::size_t n) : n_(n) {}

    [[nodiscard]] Location<2> locate(const Vec<2>& p, ElementId) const override {
        const double r = norm(p), turn = std::atan2(p[1], p[0]) / (2 * std::numbers::pi) + 0.5;
        const auto cell = [](double t, std::size_t cells) {
            return std::min(static_cast<std::size_t>(std::clamp(t, 0.0, 1.0) * static_cast<double>(cells)), cells - 1);
        };
        return {.element = ElementId(cell(r - 1, n_) * 4 * n_ + cell(turn, 4 * n_)),
                .xi = {},
                .placement = r >= 1 && r <= 2 ? Placement::inside : Placement::outside};
    }
    void sample_values(std::span<const Vec<2>> points, ElementId hint, std::span<FieldSample<2>> out) const override {
        for (std::size_t i = 0; i < points.size(); ++i) {
            out[i].location = locate(points[i], hint);
            out[i].log_metric = polar<2>(points[i], h_radial, h_tangential);
        }
    }
    void sample_with_gradients(std::span<const Vec<2>> points, ElementId hint,
                               std::span<FieldSample<2>> out) const override {
        sample_values(points, hint, out);
        const double stretch = -2 * std::log(h_radial) + 2 * std::log(h_tangential);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec<2> r = normalised(points[i]);
            for (int k = 0; k < 2; ++k) {
                Vec<2> turned = (-r[k] / norm(points[i])) * r;  // ∂_k r
                turned[k] += 1 / norm(points[i]);
                for (int a = 0; a < 2; ++a)
                    for (int b = 0; b <= a; ++b)
                        out[i].gradient[k](a, b) = stretch * (turned[a] * r[b] + r[a] * turned[b]);
            }
        }
    }
    void sample_with_recovered_gradients(std::span<const Vec<2>> points, ElementId hint,
                                         std::span<FieldSample<2>> out) const override {
        sample_with_gradients(points, hint, out);
    }
    void sample_edges(std::span<const BackEdge>, std::span<EdgeEnds<2>>) const override {}
    [[nodiscard]] std::size_t vertex_count() const override { return 0; }
    [[nodiscard]] BackVertex<2> vertex(VertexId) const override { return {}; }
    [[nodiscard]] BackSector<2> sector(ElementId, VertexId, VertexId) const override { return {}; }

  private:
    std::size_t n_;
};

}  // namespace

TEST_CASE("sampling a pack equals sampling its points in turn in 2D") { check_packs<2>(); }
TEST_CASE("sampling a pack equals sampling its points in turn in 3D") { check_packs<3>(); }

TEST_CASE("edges in a custom curved back mesh are the limit of those in straight ones") {
    const BackMesh<2> curved(CurvedCells(8));
    const EdgeMinimiserOptions options;
    const EdgeRules rules = edge_rules(options);
    std::vector<double> largest;
    for (const int n : {8, 16, 32}) {
        const auto straight = back_of(shell_block<2>({2 * n, n}, 3, 0),
                                      [](const Vec<2>& x) { return polar<2>(x, h_radial, h_tangential); });
        double off = 0;
        for (const double radius : {1.3, 1.5, 1.7}) {
            const Vec<2> a = radius * Vec<2>{{std::sin(-0.31), std::cos(-0.31)}};
            const Vec<2> b = radius * Vec<2>{{std::sin(0.17), std::cos(0.17)}};
            const auto in_curved = minimise_edge(curved, a, b, ElementId(std::size_t{0}), rules, options);
            const auto in_straight = minimise_edge<2>(straight, a, b, ElementId(std::size_t{0}), rules, options);
            CHECK(in_curved.length < in_curved.straight_length);
            CHECK_FALSE(in_curved.outside);
            off = std::fmax(off, std::fabs(in_straight.length / in_curved.length - 1));
            // Kinks of the straight field reduce the displacement of nodes by up to 1 %.
            CHECK(distance(in_curved.node.point, in_straight.node.point) <
                  0.01 * distance(in_curved.node.point, midpoint(a, b)));
        }
        largest.push_back(off);
    }
    CHECK(std::log2(largest[0] / largest[1]) > 1.5);  // O(h²)
    CHECK(std::log2(largest[1] / largest[2]) > 1.5);
}
