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
    const Fans& fans;
    std::span<const FlatPatch<3>> flats;
    const CurveTangents<3>& tangents;
    GivenAtVertices<3> given;
    double least_cosine;

    [[nodiscard]] Vec<3> area_weighted(std::uint32_t fan) const {
        Vec<3> sum;
        for (const FacetId f : fans.facets[fan]) sum += area_vector(mesh, fans, f);
        return normalised(sum);
    }

    /// The given normal at the fan's vertex that is nearest to `base`, if near enough; else the zero vector.
    [[nodiscard]] Vec<3> given_normal(VertexId v, const Vec<3>& base) const {
        double best = least_cosine;
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

    /// The plane of the fan's own facets (three or more, or the whole stencil), if they are coplanar.
    [[nodiscard]] FlatPatch<3> local_plane(std::uint32_t fan, std::span<const Vec<3>> stencil) const {
        std::vector<Vec<3>> points(stencil.begin(), stencil.end());
        points.push_back(mesh.points[fans.vertices[fan]]);
        if (fans.facets[fan].size() >= 3) {
            points.clear();
            for (const FacetId f : fans.facets[fan])
                for (const VertexId v : mesh.facets.vertices[f]) points.push_back(mesh.points[v]);
        }
        return plane_of<3>(points);
    }

    /// Well-known tangents of the ridges that bound the fan.
    [[nodiscard]] std::vector<Vec<3>> border_tangents(std::uint32_t fan) const {
        constexpr int least_support = 3;
        const VertexId v = fans.vertices[fan];
        std::vector<Vec<3>> out;
        for (const FacetId f : fans.facets[fan])
            for (const EdgeId e : edges.of_facets[f]) {
                if (features.edge_kinds[e] != EdgeKind::ridge) continue;
                const auto& ends = edges.vertices[e];
                if (ends[0] != v && ends[1] != v) continue;
                const std::size_t row = tangents.row(e), end = ends[0] == v ? 0 : 1;
                if (tangents.supports[row][end] >= least_support) out.push_back(tangents.tangents[row][end]);
            }
        return out;
    }

    [[nodiscard]] Vec<3> perpendicular_to_ridges(std::uint32_t fan, const Vec<3>& normal) const {
        constexpr double least_sine = 0.3, least_agreement = 0.8;
        const auto borders = border_tangents(fan);
        if (borders.empty()) return normal;
        Vec<3> out = normal - dot(normal, borders[0]) * borders[0];
        if (borders.size() == 2) {
            const Vec<3> across = cross(borders[0], borders[1]);
            if (norm(across) > least_sine) out = dot(across, normal) < 0 ? -across : across;
        }
        out = normalised(out);
        return dot(out, normal) > least_agreement ? out : normal;
    }

    [[nodiscard]] Vec<3> operator()(std::uint32_t fan) const {
        constexpr double least_agreement = 0.5;
        const VertexId v = fans.vertices[fan];
        const Vec<3> base = area_weighted(fan);
        const auto turned = [&](const Vec<3>& n) { return dot(n, base) < 0 ? -n : n; };
        const FlatPatch<3>& flat = flats[features.patches[fans.facets[fan][0]]];
        if (flat.is_flat()) return turned(flat.normal);
        if (fans.pointed[fan] != 0) return {};

        if (const Vec<3> normal = given_normal(v, base); norm_squared(normal) > 0) return normal;

        std::vector<Vec<3>> stencil;
        for (const std::uint32_t other : rings(mesh, fans, fan, base, {}))
            stencil.push_back(mesh.points[fans.vertices[other]]);
        if (const auto plane = local_plane(fan, stencil); plane.is_flat()) return turned(plane.normal);

        const FittedNormal jet = fitted_normal(mesh.points[v], base, stencil);
        const bool fits = jet.degree > 0 && dot(jet.normal, base) > least_agreement;
        return perpendicular_to_ridges(fan, fits ? jet.normal : base);
    }
};

}  // namespace

Outcome<Buffer<Vec<3>>> fan_normals(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                                    const Fans& fans, std::span<const FlatPatch<3>> flats,
                                    const CurveTangents<3>& tangents, double most_degrees, const Execution& execution) {
    const double least_cosine = most_degrees > 0 ? std::cos(most_degrees * std::numbers::pi / 180) : 2;
    const Fitter fit{mesh,        edges, features, fans, flats, tangents, GivenAtVertices<3>(mesh.geometry.normals),
                     least_cosine};
    return map_each(execution, fans.size(), [&](std::size_t i) { return fit(static_cast<std::uint32_t>(i)); }, 64);
}

}  // namespace camber
