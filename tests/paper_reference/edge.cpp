// Point location, gradients of lengths and minimisation of the scalar reference.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "back_field.hpp"
#include "dice.hpp"
#include "edge.hpp"
#include "matrix.hpp"
#include "meshes.hpp"
#include "minimise.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.shapes;

#include "of_mesh.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

/// A box of 3 cells per axis with a log-metric that is linear in space, hence without kinks.
paper::BackField smooth_field(Dice& dice, double change) {
    const LinearMesh<3> mesh = must(generate(BoxOptions<3>{.cells = {3, 3, 3}, .seed = dice.below(1000) + 1}));
    const Sym<3> constant = dice.symmetric<3>(3);
    std::array<Sym<3>, 3> slopes{};
    for (Sym<3>& s : slopes) s = dice.symmetric<3>(change);
    Buffer<LogMetric<3>> logs(mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) {
        logs[v].l = constant;
        for (std::size_t i = 0; i < 3; ++i) logs[v].l += mesh.points[v][i] * slopes[i];
    }
    const auto across = must(neighbours(mesh, must(balls(mesh, one_thread)), one_thread));
    return paper::field_of(mesh, across, Column<LogMetric<3>>(std::move(logs)));
}

/// An edge, given by an element and two of its vertices.
struct ElementEdge {
    std::uint32_t element, a, b;
};
ElementEdge random_edge(const paper::BackField& field, Dice& dice) {
    const auto element = static_cast<std::uint32_t>(dice.below(field.elements.size()));
    const auto& v = field.elements[element].vertices;
    const std::size_t i = dice.below(4);
    return {element, v[i], v[(i + 1 + dice.below(3)) % 4]};
}

}  // namespace

TEST_CASE("paper_reference: locate finds a point exactly if it lies in the mesh") {
    property("a point is located from any hint exactly if it is inside", [](std::uint64_t seed) {
        Dice dice(seed);
        const paper::BackField field = smooth_field(dice, 1);
        const auto hint = static_cast<std::uint32_t>(dice.below(field.elements.size()));
        const paper::Vector p{dice.vector<3>(-0.2, 1.2).c};
        const auto place = paper::locate(field, p, hint);
        bool inside = true;
        for (const double x : p.c) inside = inside && x >= 0 && x <= 1;
        RC_ASSERT(place.has_value() == inside);
        if (!place) return;
        paper::Vector again{};
        for (std::size_t j = 0; j < 4; ++j) {
            RC_ASSERT(place->u[j] >= -1e-9);
            again = again + place->u[j] * field.vertices[field.elements[place->element].vertices[j]].point;
        }
        for (std::size_t i = 0; i < 3; ++i) RC_ASSERT(std::abs(again[i] - p[i]) <= 1e-12);
    });
}

TEST_CASE("paper_reference: the gradient of a length is the limit of central differences") {
    for (const paper::Along along : {paper::Along::nodes, paper::Along::points})
        property(along == paper::Along::nodes ? "the gradient by nodes equals differences"
                                              : "the gradient by points equals differences",
                 [=](std::uint64_t seed) {
                     Dice dice(seed);
                     const paper::BackField field = smooth_field(dice, 3);
                     const ElementEdge ends = random_edge(field, dice);
                     paper::Edge edge(field, along, ends.a, ends.b, ends.element);
                     // The node moves towards the middle of the box, so that the curve stays inside.
                     const paper::Vector middle = edge.middle();
                     const paper::Vector centre{{0.5, 0.5, 0.5}};
                     const paper::Vector node = middle + dice.uniform(0.02, 0.1) * (centre - middle);
                     const paper::Length length = edge.value_and_gradient(node);
                     RC_ASSERT(std::abs(edge.value(node) - length.value) <= 1e-13 * length.value);
                     const double size = std::sqrt(paper::dot(length.gradient, length.gradient)) + length.value;
                     for (std::size_t i = 0; i < 3; ++i) {
                         const double step = 1e-6;
                         paper::Vector ahead = node;
                         paper::Vector behind = node;
                         ahead[i] += step;
                         behind[i] -= step;
                         const double difference = (edge.value(ahead) - edge.value(behind)) / (2 * step);
                         RC_ASSERT(std::abs(difference - length.gradient[i]) <= 1e-6 * size);
                     }
                 });
}

TEST_CASE("paper_reference: minimise does not increase the length of an edge") {
    property("minimise makes no edge longer than its chord", [](std::uint64_t seed) {
        Dice dice(seed);
        const paper::BackField field = smooth_field(dice, 3);
        const ElementEdge ends = random_edge(field, dice);
        const paper::Minimum m = paper::minimise(field, ends.a, ends.b, ends.element, {});
        RC_ASSERT(m.length <= m.straight_length);
        RC_ASSERT(m.work.iterations <= paper::Options{}.max_iterations);
    });
    property("minimise keeps edges straight in a constant metric", [](std::uint64_t seed) {
        Dice dice(seed);
        const paper::BackField field = smooth_field(dice, 0);
        const ElementEdge ends = random_edge(field, dice);
        const paper::Minimum m = paper::minimise(field, ends.a, ends.b, ends.element, {});
        RC_ASSERT(m.work.iterations == 0);
        RC_ASSERT(m.length == m.straight_length);
    });
}
