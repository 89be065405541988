// Irregular boundary meshes whose surface is known, for the tests of camber.surface.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.surface;

namespace surface_tests {

using namespace camber;
using Triangle = std::array<std::size_t, 3>;

inline constexpr double pi = std::numbers::pi;

template <int D>
struct Soup {
    std::vector<Vec<D>> points;
    std::vector<std::array<std::size_t, D>> facets;
    std::vector<Reference> references;  // missing ones are 1

    [[nodiscard]] LinearMesh<D> mesh() const {
        LinearMesh<D> m;
        Buffer<SimplexVertices<D - 1>> vertices(facets.size());
        Buffer<Reference> refs(facets.size());
        for (std::size_t f = 0; f < facets.size(); ++f) {
            for (std::size_t i = 0; i < D; ++i) vertices[f][i] = VertexId(facets[f][i]);
            refs[f] = f < references.size() ? references[f] : 1;
        }
        Buffer<Reference> point_references(points.size());
        for (auto& r : point_references) r = 0;
        m.points = Buffer<Vec<D>>(points.begin(), points.end());
        m.point_references = std::move(point_references);
        m.facets.vertices = std::move(vertices);
        m.facets.references = std::move(refs);
        return m;
    }
};

class Random {
  public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double operator()(double low, double high) {
        // std::uniform_real_distribution is not used, because its values differ between libraries.
        return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
    }

  private:
    std::mt19937_64 engine_;
};

enum class Closing { open, closed };

struct Grid {
    std::size_t n = 8, m = 8;  // cells in u and in v
    Closing u = Closing::open, v = Closing::open;
    double jitter = 0.25;  // as a share of a cell
    double grading = 0.3;  // sizes vary by 1 ± this
    unsigned seed = 1;
};

using Map = std::function<Vec<3>(double u, double v)>;

// A grid on [0, 1]² mapped by `map`, with random jitter of inner points and random diagonals. The rim of a grid that is
// open in both directions is fixed; points of other open rims move along them.
inline Soup<3> grid_mesh(const Grid& grid, const Map& map, Reference reference = 1) {
    Random random(grid.seed);
    Soup<3> soup;
    const std::size_t columns = grid.u == Closing::open ? grid.n + 1 : grid.n;
    const std::size_t rows = grid.v == Closing::open ? grid.m + 1 : grid.m;
    const auto place = [&](double i, double n, Closing closing) {
        const double t = i / n;
        return t + grid.grading *
                       (closing == Closing::open ? std::sin(pi * t) * t * (1 - t) : std::sin(2 * pi * t) / (2 * pi));
    };
    for (std::size_t j = 0; j < rows; ++j)
        for (std::size_t i = 0; i < columns; ++i) {
            const bool u_rim = grid.u == Closing::open && (i == 0 || i == grid.n);
            const bool v_rim = grid.v == Closing::open && (j == 0 || j == grid.m);
            const double du = random(-grid.jitter, grid.jitter), dv = random(-grid.jitter, grid.jitter);
            const bool fixed = (u_rim && grid.v == Closing::open) || (v_rim && grid.u == Closing::open);
            const double u =
                place(static_cast<double>(i) + (u_rim || fixed ? 0 : du), static_cast<double>(grid.n), grid.u);
            const double v =
                place(static_cast<double>(j) + (v_rim || fixed ? 0 : dv), static_cast<double>(grid.m), grid.v);
            soup.points.push_back(map(u, v));
        }
    const auto at = [&](std::size_t i, std::size_t j) { return (j % rows) * columns + i % columns; };
    for (std::size_t j = 0; j < grid.m; ++j)
        for (std::size_t i = 0; i < grid.n; ++i) {
            const std::size_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
            if (random(0, 1) < 0.5) {
                soup.facets.push_back({a, b, c});
                soup.facets.push_back({a, c, d});
            } else {
                soup.facets.push_back({a, b, d});
                soup.facets.push_back({b, c, d});
            }
        }
    soup.references.assign(soup.facets.size(), reference);
    return soup;
}

// Joins soups and merges points with the same coordinates to 1e-9.
inline Soup<3> welded(const std::vector<Soup<3>>& parts) {
    Soup<3> out;
    for (const auto& part : parts) {
        std::vector<std::size_t> number(part.points.size());
        for (std::size_t p = 0; p < part.points.size(); ++p) {
            number[p] = out.points.size();
            for (std::size_t q = 0; q < out.points.size(); ++q)
                if (distance(part.points[p], out.points[q]) < 1e-9) {
                    number[p] = q;
                    break;
                }
            if (number[p] == out.points.size()) out.points.push_back(part.points[p]);
        }
        for (std::size_t f = 0; f < part.facets.size(); ++f) {
            const auto& t = part.facets[f];
            out.facets.push_back({number[t[0]], number[t[1]], number[t[2]]});
            out.references.push_back(part.references[f]);
        }
    }
    return out;
}

inline Soup<3> torus(std::size_t n, double major, double minor, unsigned seed = 1) {
    const Grid grid{.n = 2 * n, .m = n, .u = Closing::closed, .v = Closing::closed, .seed = seed};
    return grid_mesh(grid, [=](double u, double v) {
        const double a = 2 * pi * u, b = 2 * pi * v, r = major + minor * std::cos(b);
        return Vec<3>{{r * std::cos(a), r * std::sin(a), minor * std::sin(b)}};
    });
}

// The wall of a cylinder of height 1 about the z axis, open at both ends.
inline Soup<3> tube(std::size_t n, std::size_t m, double radius, unsigned seed = 1, double angle = 2 * pi) {
    const bool full = angle > 6.28;
    const Grid grid{
        .n = n, .m = m, .u = full ? Closing::closed : Closing::open, .grading = full ? 0.3 : 0, .seed = seed};
    return grid_mesh(grid, [=](double u, double v) {
        return Vec<3>{{radius * std::cos(angle * u), radius * std::sin(angle * u), v}};
    });
}

// The six faces of a cube projected onto the sphere.
inline Soup<3> sphere(std::size_t n, double radius, unsigned seed = 1) {
    std::vector<Soup<3>> faces;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            // Rims of neighbouring faces must agree, so they have neither jitter nor grading.
            Grid grid{.n = n, .m = n, .jitter = 0, .grading = 0, .seed = seed + static_cast<unsigned>(axis)};
            faces.push_back(grid_mesh(grid, [=](double u, double v) {
                Vec<3> p;
                p[axis] = side;
                p[(axis + 1) % 3] = side * std::tan(pi / 4 * (2 * u - 1));
                p[(axis + 2) % 3] = std::tan(pi / 4 * (2 * v - 1));
                return radius * normalised(p);
            }));
        }
    Soup<3> out = welded(faces);
    Random random(seed);
    const double step = 0.35 * radius / static_cast<double>(n);
    for (auto& p : out.points) {
        for (std::size_t i = 0; i < 3; ++i) p[i] += random(-step, step);
        p = radius * normalised(p);
    }
    return out;
}

// The surface of the unit cube.
inline Soup<3> cube(std::size_t n, unsigned seed = 1) {
    std::vector<Soup<3>> faces;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {0.0, 1.0}) {
            const Grid grid{.n = n, .m = n, .grading = 0, .seed = seed + static_cast<unsigned>(axis)};
            faces.push_back(grid_mesh(grid, [=](double u, double v) {
                Vec<3> p;
                p[axis] = side;
                p[(axis + 1) % 3] = u;
                p[(axis + 2) % 3] = v;
                return p;
            }));
        }
    return welded(faces);
}

// The half y ≥ 0 of a cylinder of radius and height 1 about z: the wall, the plane y = 0, and two half discs. n even.
inline Soup<3> half_cylinder(std::size_t n, std::size_t m, unsigned seed = 1) {
    const auto x_of = [](double u) { return u == 0.5 ? 0.0 : std::cos(pi * u); };
    const auto wall = [=](double u, double v) { return Vec<3>{{x_of(u), u == 0 || u == 1 ? 0 : std::sin(pi * u), v}}; };
    const auto back = [=](double u, double v) { return Vec<3>{{x_of(u), 0, v}}; };
    const Grid grid{.n = n, .m = m, .grading = 0, .seed = seed};
    std::vector<Soup<3>> parts{grid_mesh(grid, wall), grid_mesh(grid, back)};
    for (const double z : {0.0, 1.0}) {
        Soup<3> cap;
        const std::size_t layers = 3;
        const auto arc = [&](std::size_t i) { return static_cast<double>(i) / static_cast<double>(n); };
        for (std::size_t i = 1; i < n; ++i)
            for (std::size_t j = 0; j <= layers; ++j) {
                const double s = static_cast<double>(j) / static_cast<double>(layers);
                Vec<3> p = (1 - s) * back(arc(i), z) + s * wall(arc(i), z);
                p[2] = z;
                cap.points.push_back(p);
            }
        const auto at = [&](std::size_t i, std::size_t j) { return (i - 1) * (layers + 1) + j; };
        for (std::size_t i = 1; i + 1 < n; ++i)
            for (std::size_t j = 0; j < layers; ++j) {
                cap.facets.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                cap.facets.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
        for (const std::size_t i : {std::size_t{1}, n - 1}) {
            const std::size_t tip = cap.points.size();
            cap.points.push_back(back(i == 1 ? 0 : 1, z));
            for (std::size_t j = 0; j < layers; ++j) cap.facets.push_back({tip, at(i, j), at(i, j + 1)});
        }
        cap.references.assign(cap.facets.size(), 1);
        parts.push_back(cap);
    }
    return welded(parts);
}

template <class Transform>
Soup<3> transformed_soup(Soup<3> soup, Transform&& transform) {
    for (auto& p : soup.points) p = transform(p);
    return soup;
}

// A rotation that mixes all axes.
inline Vec<3> rotated(const Vec<3>& p) {
    const double a = 0.7, b = 1.1;
    const Vec<3> q{{std::cos(a) * p[0] - std::sin(a) * p[1], std::sin(a) * p[0] + std::cos(a) * p[1], p[2]}};
    return {{q[0], std::cos(b) * q[1] - std::sin(b) * q[2], std::sin(b) * q[1] + std::cos(b) * q[2]}};
}

// A closed or open polygon through the points.
inline Soup<2> polygon(std::vector<Vec<2>> points, Closing closing = Closing::closed) {
    Soup<2> soup;
    const std::size_t n = points.size();
    for (std::size_t i = 0; i + (closing == Closing::open ? 1 : 0) < n; ++i) soup.facets.push_back({i, (i + 1) % n});
    soup.points = std::move(points);
    return soup;
}

template <int D>
struct Built {
    QuadraticMesh<D> mesh;
    Features<D> features;
    Surrogate<D> surrogate;
    Buffer<LagrangeNode<D>> nodes;
};

template <int D>
Built<D> build(const LinearMesh<D>& mesh, const SurrogateOptions& options = {},
               const Execution& execution = {.threads = 1}) {
    Built<D> b;
    b.mesh = elevate<D>(mesh, execution).value();
    b.features = find_features(mesh, b.mesh.edges, FeatureOptions<D>{}, execution).value();
    b.surrogate = build_surrogate(mesh, b.mesh.edges, b.features, options, execution).value();
    b.nodes = boundary_nodes(b.mesh, b.features, Geometry<D>(b.surrogate), execution).value();
    return b;
}

template <int D>
BoundaryDistance distance_of(const Built<D>& b) {
    return boundary_distance<D>(b.mesh, b.nodes, b.features, Geometry<D>(b.surrogate), {.threads = 1}).value();
}

using Off = std::function<double(const Vec<3>&)>;  // distance from the known surface

struct Errors {
    double edges = 0;      // largest error of the mid nodes
    double surrogate = 0;  // largest error of the cubic triangles, densely sampled
    double quadratic = 0;  // largest error of the P2 triangles
    double straight = 0;   // largest error of the straight triangles
};

inline Errors errors(const Built<3>& b, const Off& off) {
    Errors e;
    const auto& linear = b.mesh.linear;
    for (std::size_t f = 0; f < linear.facets.size(); ++f) {
        for (const EdgeId id : b.mesh.edges.of_facets[f]) e.edges = std::fmax(e.edges, off(b.nodes[id.index()].point));
        const auto curved =
            bezier_form<2, 3>(linear.points, b.nodes, linear.facets.vertices[f], b.mesh.edges.of_facets[f]);
        const auto straight = facet_of(b.mesh, FacetId(f));
        for (const auto& alpha : multi_indices<9, 2>) {
            const Barycentric<2> xi{alpha[0] / 9.0, alpha[1] / 9.0, alpha[2] / 9.0};
            e.surrogate = std::fmax(e.surrogate, off(point_at(b.surrogate.facets[f], xi)));
            e.quadratic = std::fmax(e.quadratic, off(curved.point(xi)));
            e.straight = std::fmax(e.straight, off(straight.point(xi)));
        }
    }
    return e;
}

inline Off off_surface(const AnalyticSurface<3>& surface) {
    return [surface](const Vec<3>& p) { return distance(p, closest_point<3>(surface, p).point); };
}

}  // namespace surface_tests
