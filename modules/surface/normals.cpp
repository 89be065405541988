module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

struct Fitter {
    const LinearMesh<3>& mesh;
    const EdgeSet<3>& edges;
    const Features<3>& features;
    const Incidence<FacetId>& shells;
    const Fans& fans;
    std::span<const FlatPatch<3>> flats;
    const CurveTangents<3>& tangents;
    const Junctions<3>& junctions;
    GivenAtVertices<3> given;
    double min_cosine;

    [[nodiscard]] Vec<3> area_weighted(std::uint32_t fan) const {
        Vec<3> sum;
        for (const FacetId f : fans.facets[fan]) sum += area_vector(mesh, fans, f);
        return normalised(sum);
    }

    /// The given normal at the fan's vertex that is nearest to `base`, if near enough; else the zero vector.
    [[nodiscard]] Vec<3> given_normal(VertexId v, const Vec<3>& base) const {
        double best = min_cosine;
        Vec<3> out;
        for (const DirectionRow& at : given.of(v)) {
            const Vec<3> normal = given.unit(at);
            const double cosine = dot(normal, base);
            if (!(std::fabs(cosine) > best)) continue;
            best = std::fabs(cosine);
            out = cosine < 0 ? -normal : normal;
        }
        return out;
    }

    /// Whether ridges bound the fan.
    [[nodiscard]] bool is_bounded(std::uint32_t fan) const {
        return std::ranges::any_of(fans.facets[fan], [&](FacetId f) {
            const std::size_t i = corner_of(mesh.facets.vertices[f], fans.vertices[fan]);
            return !fans.neighbours[f][(i + 1) % 3].valid() || !fans.neighbours[f][(i + 2) % 3].valid();
        });
    }

    /// The plane of the fan's own facets (three or more, or the whole stencil), if they are coplanar. Beside a ridge
    /// those around them too: a row of facets along it is in one plane on a cylinder as well.
    [[nodiscard]] FlatPatch<3> local_plane(std::uint32_t fan, std::span<const Vec<3>> stencil) const {
        std::vector<Vec<3>> points(stencil.begin(), stencil.end());
        points.push_back(mesh.points[fans.vertices[fan]]);
        if (fans.facets[fan].size() >= 3) {
            points.clear();
            const auto add = [&](std::uint32_t of) {
                for (const FacetId f : fans.facets[of])
                    for (const VertexId v : mesh.facets.vertices[f]) points.push_back(mesh.points[v]);
            };
            add(fan);
            if (is_bounded(fan))
                for (const FacetId f : fans.facets[fan])
                    for (const std::uint32_t other : fans.of_facets[f])
                        if (other != fan) add(other);
        }
        return plane_of<3>(points);
    }

    /// Well-known tangents of the ridges that bound the fan.
    [[nodiscard]] std::vector<Vec<3>> border_tangents(std::uint32_t fan) const {
        constexpr int min_support = 3;
        const VertexId v = fans.vertices[fan];
        std::vector<Vec<3>> out;
        for (const FacetId f : fans.facets[fan])
            for (const EdgeId e : edges.of_facets[f]) {
                if (features.edge_kinds[e] != EdgeKind::ridge) continue;
                const auto& ends = edges.vertices[e];
                if (ends[0] != v && ends[1] != v) continue;
                const std::size_t row = tangents.row(e), end = ends[0] == v ? 0 : 1;
                if (tangents.supports[row][end] >= min_support) out.push_back(tangents.tangents[row][end]);
            }
        return out;
    }

    [[nodiscard]] Vec<3> perpendicular_to_ridges(std::uint32_t fan, const Vec<3>& normal) const {
        constexpr double min_sine = 0.3, min_agreement = 0.8;
        const auto borders = border_tangents(fan);
        if (borders.empty()) return normal;
        Vec<3> out = normal - dot(normal, borders[0]) * borders[0];
        if (borders.size() == 2) {
            const Vec<3> across = cross(borders[0], borders[1]);
            if (norm(across) > min_sine) out = dot(across, normal) < 0 ? -across : across;
        }
        out = normalised(out);
        return dot(out, normal) > min_agreement ? out : normal;
    }

    [[nodiscard]] std::vector<Vec<3>> points_around(std::uint32_t fan, const Vec<3>& base) const {
        std::vector<Vec<3>> points;
        for (const std::uint32_t other : rings(mesh, fans, fan, base, {}))
            points.push_back(mesh.points[fans.vertices[other]]);
        return points;
    }

    /// Of the jet through points around the fan's vertex; the zero vector where there are too few, or it is far off.
    [[nodiscard]] Vec<3> fitted(std::uint32_t fan, const Vec<3>& base, std::span<const Vec<3>> points) const {
        constexpr double min_agreement = 0.5;
        const FittedNormal jet = fitted_normal(mesh.points[fans.vertices[fan]], base, points);
        return jet.degree > 0 && dot(jet.normal, base) > min_agreement ? jet.normal : Vec<3>{};
    }

    /// The normal of the prescribed surface that the fan goes on in, else the zero vector. One side alone tells it on
    /// either side of a jump of the curvature, both together where this side's part is but a tooth.
    [[nodiscard]] Vec<3> prescribed(std::uint32_t fan, const Vec<3>& one_sided, std::vector<Vec<3>> points) const {
        constexpr double min_agreement = 0.7;
        constexpr double both_sides = 0.5;  // what is fitted from there errs less, and a crease shows as half of it
        const Beyond beyond = beyond_fan(junctions, mesh, edges, features, shells, fans, fan, one_sided);
        if (!beyond.facet.valid() || dot(beyond.normal, one_sided) < min_agreement) return {};
        const auto agrees = [&](const Vec<3>& n, double tolerance) {
            return norm_squared(n) > 0 && atan2(norm(cross(n, beyond.normal)), dot(n, beyond.normal)) <= tolerance;
        };
        if (agrees(one_sided, beyond.tolerance)) return beyond.normal;
        const auto& facet = mesh.facets.vertices[beyond.facet];
        const std::uint32_t other = fans.of_facets[beyond.facet][corner_of(facet, fans.vertices[fan])];
        for (const Vec<3>& p : points_around(other, area_weighted(other)))
            if (std::ranges::find(points, p) == points.end()) points.push_back(p);
        return agrees(fitted(fan, beyond.normal, points), both_sides * beyond.tolerance) ? beyond.normal : Vec<3>{};
    }

    struct Normal {
        Vec<3> direction;
        bool is_prescribed = false;
    };
    [[nodiscard]] Normal operator()(std::uint32_t fan) const {
        const Vec<3> base = area_weighted(fan);
        const auto turned = [&](const Vec<3>& n) { return dot(n, base) < 0 ? -n : n; };
        const FlatPatch<3>& flat = flats[features.patches[fans.facets[fan][0]]];
        if (flat.is_flat()) return {turned(flat.normal)};
        if (fans.pointed[fan] != 0) return {};

        if (const Vec<3> normal = given_normal(fans.vertices[fan], base); norm_squared(normal) > 0) return {normal};

        const auto points = points_around(fan, base);
        if (const auto plane = local_plane(fan, points); plane.is_flat()) return {turned(plane.normal)};

        const Vec<3> jet = fitted(fan, base, points);
        const Vec<3> own = norm_squared(jet) > 0 ? jet : base;
        const Vec<3> beyond = prescribed(fan, own, points);
        return norm_squared(beyond) > 0 ? Normal{beyond, true} : Normal{perpendicular_to_ridges(fan, own)};
    }
};

}  // namespace

Outcome<FanNormals> fan_normals(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                                const Incidence<FacetId>& shells, const Fans& fans, std::span<const FlatPatch<3>> flats,
                                const CurveTangents<3>& tangents, const Junctions<3>& junctions, double max_degrees,
                                const Execution& execution) {
    const double min_cosine = max_degrees > 0 ? cos(max_degrees * std::numbers::pi / 180) : 2;
    const Fitter fit{
        mesh,      edges, features, shells, fans, flats, tangents, junctions, GivenAtVertices<3>(mesh.geometry.normals),
        min_cosine};
    Buffer<std::uint8_t> prescribed(fans.size());
    auto normals = map_each(
        execution, fans.size(),
        [&](std::size_t i) {
            const auto normal = fit(static_cast<std::uint32_t>(i));
            prescribed[i] = normal.is_prescribed ? 1 : 0;
            return normal.direction;
        },
        64);
    if (!normals) return fail(normals.error());
    return FanNormals{std::move(*normals), std::move(prescribed)};
}

}  // namespace camber
