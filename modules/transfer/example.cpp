// Example of camber.transfer: the values of a front are transferred between meshes of 10 x 10 and 13 x 13 cells ten
// times, by interpolation and by conservative projection.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <span>
#include <utility>

import camber.core;
import camber.transfer;

using namespace camber;

static LinearMesh<2> square(std::size_t n) {
    LinearMesh<2> mesh;
    Buffer<Vec<2>> points;
    Buffer<SimplexVertices<2>> triangles;
    const auto at = [n](std::size_t i, std::size_t j) { return VertexId(j * (n + 1) + i); };
    for (std::size_t j = 0; j <= n; ++j)
        for (std::size_t i = 0; i <= n; ++i) {
            points.push_back({{static_cast<double>(i) / n, static_cast<double>(j) / n}});
            if (i == n || j == n) continue;
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(triangles.size(), 1);
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(triangles);
    return mesh;
}

static Outcome<QuadraticMesh<2>> of_degree_2(LinearMesh<2> linear, const Execution& execution) {
    auto edges = unique_edges(linear, execution);
    if (!edges) return fail(edges.error());
    Buffer<LagrangeNode<2>> nodes;
    for (std::size_t e = 0; e < edges->size(); ++e) {
        const VertexId a = edges->vertices[EdgeId(e)][0], b = edges->vertices[EdgeId(e)][1];
        nodes.push_back({midpoint(linear.points[a], linear.points[b])});
    }
    return QuadraticMesh<2>{std::move(linear), std::move(*edges), std::move(nodes)};
}

static TransferField front(const QuadraticMesh<2>& mesh) {
    Buffer<double> values;
    const auto put = [&](const Vec<2>& x) { values.push_back(camber::tanh((norm(x) - 0.7) / 0.05)); };
    for (const Vec<2>& x : mesh.linear.points) put(x);
    for (const LagrangeNode<2>& node : mesh.mid_nodes) put(node.point);
    return {.components = 1, .degree = 2, .values = std::move(values)};
}

struct Lost {
    double largest = 0, integral = 0;
};

static Outcome<Lost> round_trip(TransferMethod method, const Execution& execution) {
    const auto a = of_degree_2(square(10), execution), b = of_degree_2(square(13), execution);
    if (!a) return fail(a.error());
    if (!b) return fail(b.error());
    const TransferField begin = front(*a);
    TransferField field = begin;
    double first = 0, last = 0;
    for (int k = 0; k < 10; ++k) {
        const auto there = transfer<2>(*a, std::span(&field, 1), *b, {.method = method}, execution);
        if (!there) return fail(there.error());
        auto back = transfer<2>(*b, there->fields, *a, {.method = method}, execution);
        if (!back) return fail(back.error());
        field = std::move(back->fields[0]);
        if (k == 0) first = there->statistics.integrals[0][0].before[0];
        last = back->statistics.integrals[0][0].after[0];
    }
    Lost lost{0, std::abs(last - first)};
    for (std::size_t i = 0; i < field.values.size(); ++i)
        lost.largest = std::max(lost.largest, std::abs(field.values[i] - begin.values[i]));
    return lost;
}

static Outcome<bool> example(const Execution& execution) {
    const auto interpolated = round_trip(TransferMethod::interpolate, execution);
    if (!interpolated) return fail(interpolated.error());
    const auto preserved = round_trip(TransferMethod::conserve, execution);
    if (!preserved) return fail(preserved.error());
    std::printf(
        "             largest error   integral lost\ninterpolate  %.3e       %.3e\nconserve     %.3e       %.3e\n",
        interpolated->largest, interpolated->integral, preserved->largest, preserved->integral);
    return preserved->integral < 1e-13 && interpolated->integral > 1e-6;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
