// A quadratic mesh with mapped vertices and nodes.
#pragma once

#include <functional>
#include <utility>

import camber.core;

namespace camber::testing {

template <int D>
QuadraticMesh<D> mapped(QuadraticMesh<D> mesh, const std::function<Vec<D>(const Vec<D>&)>& f) {
    auto points = take(std::move(mesh.linear.points));
    for (auto& p : points) p = f(p);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (auto& n : nodes) n.point = f(n.point);
    mesh.linear.points = std::move(points);
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

}  // namespace camber::testing
