module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

/// Random orthonormal axes, by Gram–Schmidt.
std::array<Vec<3>, 3> random_axes(const Noise& noise) {
    std::uint64_t draw = 0;
    const auto direction = [&] {
        Vec<3> v;
        do v = noise.vector<3>(draw++);
        while (norm_squared(v) > 1 || norm_squared(v) < 0.01);
        return normalised(v);
    };
    const Vec<3> x = direction();
    Vec<3> y;
    do {
        const Vec<3> v = direction();
        y = v - dot(v, x) * x;
    } while (norm_squared(y) < 0.01);
    y = normalised(y);
    return {x, y, cross(x, y)};
}

Buffer<Vec<2>> circle(std::size_t n, double start) {
    Buffer<Vec<2>> points(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + start) / static_cast<double>(n);
        points[i] = normalised(Vec<2>{{cos(angle), sin(angle)}});
    }
    return points;
}

/// Points of the icosphere by exact lattice weights on the icosahedron's corners, so that faces share them.
class IcosphereBuilder {
  public:
    explicit IcosphereBuilder(int n) : n_(n), side_(static_cast<std::size_t>(n) + 1) {}

    UnitSphere<3> build() {
        constexpr double g = std::numbers::phi;
        for (const auto& [a, b] : std::array<std::array<double, 2>, 4>{{{-1, g}, {1, g}, {-1, -g}, {1, -g}}}) {
            corners_.push_back({{a, b, 0}});
            corners_.push_back({{0, a, b}});
            corners_.push_back({{b, 0, a}});
        }
        const std::size_t squares = (side_ - 1) * (side_ - 1);
        sphere_.points.reserve(10 * squares + 2);
        sphere_.facets.reserve(20 * squares);
        on_edges_.resize(12 * 12);
        // Faces of the icosahedron: triples at the least distance, 2.
        for (int a = 0; a < 12; ++a)
            for (int b = a + 1; b < 12; ++b)
                for (int c = b + 1; c < 12; ++c)
                    if (adjacent(a, b) && adjacent(b, c) && adjacent(a, c)) add_face({a, b, c});
        return std::move(sphere_);
    }

  private:
    [[nodiscard]] bool adjacent(int a, int b) const { return norm_squared(corners_[a] - corners_[b]) < 5; }

    void add_face(std::array<int, 3> face) {
        if (det(corners_[face[0]], corners_[face[1]], corners_[face[2]]) < 0) std::swap(face[0], face[1]);
        inside_.assign(side_ * side_, VertexId());
        const auto at = [&](int i, int j) { return vertex(face, {n_ - i - j, i, j}); };
        for (int i = 0; i < n_; ++i)
            for (int j = 0; i + j < n_; ++j) {
                sphere_.facets.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
                if (i + j + 2 <= n_) sphere_.facets.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    }

    VertexId vertex(const std::array<int, 3>& face, const std::array<int, 3>& weights) {
        VertexId& id = place(face, weights);
        if (id.valid()) return id;
        id = VertexId(sphere_.points.size());
        std::array<int, 3> order{0, 1, 2};
        std::sort(order.begin(), order.end(), [&](int a, int b) { return face[a] < face[b]; });
        Vec<3> p;
        for (const int k : order)
            if (weights[k] > 0) p += static_cast<double>(weights[k]) * corners_[face[k]];
        sphere_.points.push_back(normalised(p));
        return id;
    }

    /// Where the id of a lattice point is kept: with a corner, an edge of the icosahedron, or the face under way.
    VertexId& place(const std::array<int, 3>& face, const std::array<int, 3>& weights) {
        for (int k = 0; k < 3; ++k) {
            if (weights[k] == n_) return at_corners_[face[k]];
            if (weights[k] > 0) continue;
            int low = (k + 1) % 3, high = (k + 2) % 3;
            if (weights[low] == 0 || weights[high] == 0) continue;
            if (face[low] > face[high]) std::swap(low, high);
            auto& edge = on_edges_[static_cast<std::size_t>(face[low]) * 12 + face[high]];
            edge.resize(side_);
            return edge[weights[low]];
        }
        return inside_[side_ * weights[1] + weights[2]];
    }

    int n_;
    std::size_t side_;
    std::vector<Vec<3>> corners_;
    std::array<VertexId, 12> at_corners_;
    std::vector<std::vector<VertexId>> on_edges_;  ///< by lesser corner × 12 + greater, then by the lesser's weight
    std::vector<VertexId> inside_;
    UnitSphere<3> sphere_;
};

}  // namespace

template <>
Buffer<Vec<2>> spread_points<2>(std::size_t n, const Noise& noise) {
    return circle(n, noise.symmetric(0));
}

template <>
Buffer<Vec<3>> spread_points<3>(std::size_t n, const Noise& noise) {
    const auto axes = random_axes(noise);
    const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
    const double c = cos(golden_angle), s = sin(golden_angle);
    Buffer<Vec<3>> points(n);
    double x = 1, y = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(n);
        const double r = std::sqrt(1 - z * z);
        points[i] = normalised(r * x * axes[0] + r * y * axes[1] + z * axes[2]);
        const double turned = c * x - s * y;
        y = s * x + c * y;
        x = turned;
    }
    return points;
}

template <>
UnitSphere<2> icosphere<2>(int n) {
    UnitSphere<2> sphere{circle(5 * static_cast<std::size_t>(n), 0), {}};
    const std::size_t count = sphere.points.size();
    // Clockwise, so that (the edge, the way outwards) is a positive frame, as for triangles in 3D.
    for (std::size_t i = 0; i < count; ++i) sphere.facets.push_back({VertexId((i + 1) % count), VertexId(i)});
    return sphere;
}

template <>
UnitSphere<3> icosphere<3>(int n) {
    return IcosphereBuilder(n).build();
}

}  // namespace camber
