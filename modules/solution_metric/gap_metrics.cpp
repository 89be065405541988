module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.solution_metric;
import camber.core;
import camber.box_tree;
import camber.metric;

namespace camber {

namespace {

/// Facets are extended by this fraction, so that a ray cannot pass between two facets at their common edge. Rounding
/// errors are far smaller.
constexpr double margin = 1e-4;

template <int D>
struct Walls {
    Buffer<Vec<D>> normals;
    Buffer<std::array<std::optional<Reference>, 2>> materials;  ///< references of the elements at each facet: [0]
                                                                ///< behind it, [1] on the side of its normal
    BoxTree<D> tree;
};

template <int D>
void find_materials(const LinearMesh<D>& mesh, const Incidence<FacetId>& balls, Walls<D>& walls) {
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const auto& corners = mesh.elements.vertices[e];
        const auto inner = std::ranges::count_if(corners, [&](VertexId v) { return balls[v].empty(); });
        if (inner > 1) continue;
        for (int opposite = 0; opposite <= D; ++opposite) {
            const auto is_of_face = [&](VertexId v) {
                return v != corners[opposite] && std::ranges::find(corners, v) != corners.end();
            };
            for (const FacetId f : balls[corners[opposite == 0 ? 1 : 0]]) {
                const auto& v = mesh.facets.vertices[f];
                if (!std::ranges::all_of(v, is_of_face)) continue;
                const Vec<D> inward = mesh.points[corners[opposite]] - mesh.points[v[0]];
                walls.materials[f.index()][dot(walls.normals[f.index()], inward) > 0 ? 1 : 0] =
                    mesh.elements.references[e];
            }
        }
    }
}

template <int D>
Outcome<Walls<D>> make_walls(const LinearMesh<D>& mesh, const Incidence<FacetId>& balls, const Execution& execution) {
    Walls<D> walls;
    const std::size_t n = mesh.facets.size();
    walls.normals.resize(n);
    walls.materials.assign(n, {});
    Buffer<Box<D>> boxes(n);
    auto done = each(execution, n, [&](std::size_t i) {
        const FacetId f(i);
        walls.normals[i] = normalised(area_normal(mesh, f));
        Box<D> box;
        for (const VertexId v : mesh.facets.vertices[f]) box.include(mesh.points[v]);
        const double more = 2 * margin * norm(box.high - box.low);
        for (int k = 0; k < D; ++k) {
            box.low[k] -= more;
            box.high[k] += more;
        }
        boxes[i] = box;
    });
    if (!done) return fail(done.error());
    find_materials(mesh, balls, walls);
    walls.tree = BoxTree<D>(boxes);
    return walls;
}

std::array<double, 2> shares(const std::array<Vec<1>, 2>& across) {
    const double all = across[1][0] - across[0][0];
    return {across[1][0] / all, -across[0][0] / all};
}
std::array<double, 3> shares(const std::array<Vec<2>, 3>& across) {
    std::array<double, 3> area{};
    for (int i = 0; i < 3; ++i) area[i] = det(across[(i + 1) % 3], across[(i + 2) % 3]);
    const double all = area[0] + area[1] + area[2];
    return {area[0] / all, area[1] / all, area[2] / all};
}

template <int D>
struct Ray {
    Vec<D> normal;
    Reference material = 0;
};

template <int D>
class Gaps {
  public:
    Gaps(const LinearMesh<D>& mesh, const Walls<D>& walls) : mesh_(mesh), walls_(walls) {}

    /// Finds the rays from the facets of one patch: one into each adjacent material, or one on either side if both
    /// materials are the same.
    void find_rays(Side side, std::vector<Ray<D>>& rays) const {
        rays.clear();
        for (const FacetId f : side) {
            const auto& materials = walls_.materials[f.index()];
            const bool is_inside = materials[0] && materials[1] && *materials[0] == *materials[1];
            for (int along = 0; along < 2; ++along) {
                if (!materials[along]) continue;
                const Vec<D> inward = (along == 1 ? 1.0 : -1.0) * area_normal(mesh_, f);
                const auto known = std::ranges::find_if(rays, [&](const Ray<D>& ray) {
                    return ray.material == *materials[along] && (!is_inside || dot(ray.normal, inward) > 0);
                });
                if (known == rays.end())
                    rays.push_back({inward, *materials[along]});
                else
                    known->normal += inward;
            }
        }
        for (Ray<D>& ray : rays) ray.normal = normalised(ray.normal);
    }

    [[nodiscard]] std::optional<double> thickness(VertexId from, const Ray<D>& ray, Side side, double within) const {
        constexpr double facing = 0.7;  // about cos 45°
        if (!(norm_squared(ray.normal) > 0)) return std::nullopt;
        const double same_place = place_size(side);
        const auto tangents = tangents_of(ray.normal);
        const auto meets = [&](std::size_t f) {
            const double s = passes(FacetId(f), from, ray.normal, tangents);
            if (!(s > same_place)) return never;
            return is_visible_from_inside(f, ray) ? s : s + same_place;
        };
        const auto met = walls_.tree.first_hit(mesh_.points[from], ray.normal, meets, within);
        if (met.item >= mesh_.facets.size() || !is_visible_from_inside(met.item, ray)) return std::nullopt;
        if (!(std::abs(dot(walls_.normals[met.item], ray.normal)) >= facing)) return std::nullopt;
        return met.distance;
    }

  private:
    static constexpr double never = std::numeric_limits<double>::infinity();

    /// True if the elements on the ray's side of the facet have the material in which the ray starts. They do not if
    /// the ray has left the domain.
    [[nodiscard]] bool is_visible_from_inside(std::size_t f, const Ray<D>& ray) const {
        return walls_.materials[f][dot(walls_.normals[f], ray.normal) > 0 ? 0 : 1] == ray.material;
    }
    /// Distance below which points count as coincident. The facets on both sides of a crack coincide. A ray must not
    /// hit the opposite one at its start, and must hit the near one first at its end.
    [[nodiscard]] double place_size(Side side) const {
        double longest = 0;
        for (const FacetId f : side) {
            const auto& v = mesh_.facets.vertices[f];
            for (int i = 1; i < D; ++i) longest = std::max(longest, distance(mesh_.points[v[i]], mesh_.points[v[0]]));
        }
        return 1e-6 * longest;
    }
    [[nodiscard]] double passes(FacetId f, VertexId from, const Vec<D>& direction,
                                const std::array<Vec<D>, D - 1>& tangents) const {
        constexpr double along = 0.0175;  // sine of 1°
        const auto& v = mesh_.facets.vertices[f];
        if (!(std::abs(dot(walls_.normals[f.index()], direction)) > along)) return never;
        if (std::ranges::find(v, from) != v.end()) return never;
        std::array<Vec<D - 1>, D> across;
        std::array<double, D> depth{};
        for (int i = 0; i < D; ++i) {
            const Vec<D> corner = mesh_.points[v[i]] - mesh_.points[from];
            for (int k = 0; k < D - 1; ++k) across[i][k] = dot(tangents[k], corner);
            depth[i] = dot(direction, corner);
        }
        double s = 0;
        const auto share = shares(across);
        for (int i = 0; i < D; ++i) {
            if (!(share[i] >= -margin)) return never;
            s += share[i] * depth[i];
        }
        return s;
    }

    const LinearMesh<D>& mesh_;
    const Walls<D>& walls_;
};

template <int D>
LogMetric<D> metric_across(const Vec<D>& normal, double size, double largest) {
    Vec<D> sizes;
    Mat<D> axes;
    const auto tangents = tangents_of(normal);
    for (int i = 0; i < D - 1; ++i) {
        sizes[i] = largest;
        axes.column[i] = tangents[i];
    }
    sizes[D - 1] = std::max(size, min_length);
    axes.column[D - 1] = normal;
    return log_metric_of_sizes(sizes, axes);
}

template <int D>
MetricsAtVertices<D> vertices_with_metric(const Buffer<VertexId>& vertices,
                                          const Buffer<std::optional<LogMetric<D>>>& found) {
    Buffer<VertexId> at;
    Buffer<LogMetric<D>> logs;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (!found[i]) continue;
        at.push_back(vertices[i]);
        logs.push_back(*found[i]);
    }
    return {std::move(at), std::move(logs)};
}

}  // namespace

template <int D>
Outcome<MetricsAtVertices<D>> gap_metrics(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                          const GapOptions& options, double largest, const Execution& execution) {
    if (auto sound = check_limits(options); !sound) return fail(sound.error());
    if (auto sound = check_sides(mesh, patches, largest); !sound) return fail(sound.error());
    const auto balls = facet_balls(mesh, without_progress(execution));
    if (!balls) return fail(balls.error());
    return guarded([&]() -> Outcome<MetricsAtVertices<D>> {
        const auto walls = make_walls(mesh, *balls, without_progress(execution));
        if (!walls) return fail(walls.error());
        const Gaps<D> gaps(mesh, *walls);
        Buffer<VertexId> vertices;
        for (std::size_t v = 0; v < balls->size(); ++v)
            if (!(*balls)[v].empty()) vertices.push_back(VertexId(v));
        Buffer<std::optional<LogMetric<D>>> found(vertices.size(), std::nullopt);
        auto done = each_chunk(execution, vertices.size(), [&](std::size_t begin, std::size_t end) {
            std::vector<FacetId> facets;
            std::vector<Ray<D>> rays;
            for (std::size_t i = begin; i < end; ++i)
                each_side((*balls)[vertices[i]], patches, facets, [&](Side side) {
                    gaps.find_rays(side, rays);
                    for (const Ray<D>& ray : rays) {
                        const auto t = gaps.thickness(vertices[i], ray, side, options.elements * largest);
                        if (!t) continue;
                        const auto own = metric_across(ray.normal, *t / options.elements, largest);
                        found[i] = found[i] ? intersection(*found[i], own) : own;
                    }
                });
        });
        if (!done) return fail(done.error());
        return vertices_with_metric<D>(vertices, found);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<MetricsAtVertices<D>> gap_metrics<D>(const LinearMesh<D>&, const Column<std::uint32_t>&, \
                                                          const GapOptions&, double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
