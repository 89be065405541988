// Describes the boundary of a mesh and finds suspicious places.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// Facets at an edge (2D: at a vertex, which `ends` contains twice).
template <int D>
struct Hinge {
    std::array<VertexId, 2> ends;
    std::vector<FacetId> facets;
    bool is_ridge = false, is_listed = false;
    std::uint32_t curve = no_feature;
};

void add_once(std::vector<Reference>& references, Reference r) {
    const auto at = std::lower_bound(references.begin(), references.end(), r);
    if (at == references.end() || *at != r) references.insert(at, r);
}

std::vector<std::uint8_t> listed_ridges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges) {
    std::vector<std::uint8_t> listed(edges.size(), 0);
    for (const std::uint32_t r : mesh.ridges)
        if (r < edges.of_edges.size()) listed[edges.of_edges[r].index()] = 1;
    return listed;
}

Vec<3> into(const LinearMesh<3>& mesh, const std::array<VertexId, 2>& ends, FacetId f) {
    const Vec<3>&a = mesh.points[ends[0]], &b = mesh.points[ends[1]];
    for (const VertexId v : mesh.facets.vertices[f])
        if (v != ends[0] && v != ends[1]) {
            const Vec<3> d = mesh.points[v] - a, along = b - a;
            const double length = norm_squared(along);
            return length > 0 ? d - dot(d, along) / length * along : d;
        }
    return {};
}
Vec<2> into(const LinearMesh<2>& mesh, const std::array<VertexId, 2>& ends, FacetId f) {
    const auto& [a, b] = mesh.facets.vertices[f];
    return mesh.points[a == ends[0] ? b : a] - mesh.points[ends[0]];
}

double degrees_between(const Vec<3>& a, const Vec<3>& b) {
    return atan2(norm(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}
double degrees_between(const Vec<2>& a, const Vec<2>& b) {
    return atan2(std::fabs(a[0] * b[1] - a[1] * b[0]), dot(a, b)) * 180 / std::numbers::pi;
}

/// Angle in degrees by which two facets turn, for any orientation.
template <int D>
double turn_at(const LinearMesh<D>& mesh, const Hinge<D>& hinge) {
    return 180 - degrees_between(into(mesh, hinge.ends, hinge.facets[0]), into(mesh, hinge.ends, hinge.facets[1]));
}

bool have_same_direction(const LinearMesh<3>& mesh, const Hinge<3>& hinge) {
    const auto is_ascending = [&](FacetId f) {
        const auto& v = mesh.facets.vertices[f];
        for (std::size_t i = 0; i < 3; ++i)
            if (v[i] == hinge.ends[0]) return v[(i + 1) % 3] == hinge.ends[1];
        return false;
    };
    return is_ascending(hinge.facets[0]) == is_ascending(hinge.facets[1]);
}
bool have_same_direction(const LinearMesh<2>& mesh, const Hinge<2>& hinge) {
    const auto begins = [&](FacetId f) { return mesh.facets.vertices[f][0] == hinge.ends[0]; };
    return begins(hinge.facets[0]) == begins(hinge.facets[1]);
}

template <int D>
std::size_t elements_beside(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, FacetId f) {
    const auto& facet = mesh.facets.vertices[f];
    std::size_t count = 0;
    for (const ElementId e : balls[facet[0]]) {
        const auto& element = mesh.elements.vertices[e];
        count += std::all_of(facet.begin(), facet.end(),
                             [&](VertexId v) { return std::find(element.begin(), element.end(), v) != element.end(); });
    }
    return count;
}

template <int D>
void add_patches(const LinearMesh<D>& mesh, const Features<D>& features, std::span<const std::uint8_t> beside,
                 BoundaryInspection<D>& out) {
    constexpr double flat = 1e-12;
    out.patches.resize(features.patch_count);
    std::vector<Box<D>> boxes(features.patch_count);
    std::vector<Plane<D>> planes(features.patch_count);
    std::vector<double> largest(features.patch_count, -1);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const std::uint32_t at = features.patches[f];
        PatchFacts& patch = out.patches[at];
        const FacetSite<D> site = facet_site(mesh, FacetId(f));
        const double area = straight_measure(site);
        ++patch.facets;
        patch.interface_facets += beside[f] == 2 ? 1 : 0;
        patch.area += area;
        add_once(patch.references, site.reference);
        for (const Vec<D>& p : site.corners) boxes[at].include(p);
        if (area <= largest[at]) continue;
        largest[at] = area;
        planes[at] = plane_through(site.corners);
    }
    for (std::size_t at = 0; at < out.patches.size(); ++at) {
        out.patches[at].size = boxes[at].diagonal();
        out.patches[at].is_flat = true;
    }
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const std::uint32_t at = features.patches[f];
        for (const VertexId v : mesh.facets.vertices[f]) {
            const double off = distance(foot(planes[at], mesh.points[v]).point, mesh.points[v]);
            if (off > flat * out.patches[at].size) out.patches[at].is_flat = false;
        }
    }
}

void add_curves(const LinearMesh<3>& mesh, const Features<3>& features, const std::vector<Hinge<3>>& hinges,
                BoundaryInspection<3>& out) {
    out.curves.resize(features.curve_count);
    for (CurveFacts& curve : out.curves) curve.min_turn = 180;
    for (const Hinge<3>& hinge : hinges) {
        if (!hinge.is_ridge || hinge.curve == no_feature) continue;
        CurveFacts& curve = out.curves[hinge.curve];
        ++curve.edges;
        curve.length += distance(mesh.points[hinge.ends[0]], mesh.points[hinge.ends[1]]);
        for (const FacetId f : hinge.facets) add_once(curve.references, mesh.facets.references[f]);
        if (hinge.facets.size() != 2) continue;
        const double turn = turn_at(mesh, hinge);
        curve.min_turn = std::fmin(curve.min_turn, turn);
        curve.largest_turn = std::fmax(curve.largest_turn, turn);
    }
    for (CurveFacts& curve : out.curves) curve.min_turn = std::fmin(curve.min_turn, curve.largest_turn);
}

template <int D>
void add_hinges(const LinearMesh<D>& mesh, const std::vector<Hinge<D>>& hinges, BoundaryInspection<D>& out) {
    for (const Hinge<D>& hinge : hinges) {
        if (hinge.facets.size() == 1) out.open.push_back(hinge.ends);
        if (hinge.facets.size() > 2) out.crowded.push_back(hinge.ends);
        if (hinge.facets.size() == 2 && have_same_direction(mesh, hinge))
            out.turned.push_back({hinge.ends, {hinge.facets[0], hinge.facets[1]}});
    }
}

template <int D>
Outcome<std::vector<Hinge<D>>> find_hinges(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                           const Features<D>& features, const Execution& execution) {
    std::vector<Hinge<D>> hinges;
    if constexpr (D == 3) {
        const auto shells = facet_shells(edges, without_progress(execution));
        if (!shells) return fail(shells.error());
        const auto listed = listed_ridges(mesh, edges);
        for (std::size_t e = 0; e < edges.size(); ++e) {
            const auto around = (*shells)[e];
            if (around.empty()) continue;
            hinges.push_back({edges.vertices[e],
                              {around.begin(), around.end()},
                              features.edge_kinds[e] == EdgeKind::ridge,
                              listed[e] != 0,
                              features.curves[e]});
        }
    } else {
        const auto around_vertices = facet_balls(mesh, without_progress(execution));
        if (!around_vertices) return fail(around_vertices.error());
        std::vector<std::uint8_t> listed(mesh.points.size(), 0);
        for (const VertexId v : mesh.corners) listed[v.index()] = 1;
        for (std::size_t v = 0; v < around_vertices->size(); ++v) {
            const auto around = (*around_vertices)[v];
            if (around.empty()) continue;
            hinges.push_back({{VertexId(v), VertexId(v)},
                              {around.begin(), around.end()},
                              features.vertex_kinds[v] == VertexKind::corner,
                              listed[v] != 0,
                              no_feature});
        }
    }
    return hinges;
}

template <int D>
void add_turns(const LinearMesh<D>& mesh, const std::vector<Hinge<D>>& hinges, const InspectionLimits& limits,
               std::vector<LocatedWarning<D>>& out) {
    for (const Hinge<D>& hinge : hinges) {
        if (hinge.facets.size() != 2) continue;
        const double turn = turn_at(mesh, hinge);
        const bool by_angle =
            !hinge.is_listed && mesh.facets.references[hinge.facets[0]] == mesh.facets.references[hinge.facets[1]];
        const auto add = [&](GeometryWarning what) {
            LocatedWarning<D> warning{
                what, turn, midpoint(mesh.points[hinge.ends[0]], mesh.points[hinge.ends[1]]), {}, {}};
            warning.vertices.assign(hinge.ends.begin(), D == 3 ? hinge.ends.end() : hinge.ends.begin() + 1);
            warning.facets = hinge.facets;
            out.push_back(std::move(warning));
        };
        if (turn >= limits.knife_edge)
            add(GeometryWarning::knife_edge);
        else if (!hinge.is_ridge && turn >= limits.near * limits.ridge_angle)
            add(GeometryWarning::near_ridge);
        else if (hinge.is_ridge && by_angle && turn <= limits.ridge_angle / limits.near)
            add(GeometryWarning::mild_ridge);
    }
}

/// Angle-weighted normals of fans, which do not depend on the triangulation.
std::vector<Vec<3>> normals_of(const LinearMesh<3>& mesh, const Fans& fans) {
    std::vector<Vec<3>> normals(fans.size());
    for (std::size_t fan = 0; fan < fans.size(); ++fan) {
        for (const FacetId f : fans.facets[fan]) {
            const auto& v = mesh.facets.vertices[f];
            const std::size_t i = corner_of(v, fans.vertices[fan]);
            const Vec<3> a = mesh.points[v[(i + 1) % 3]] - mesh.points[v[i]];
            const Vec<3> b = mesh.points[v[(i + 2) % 3]] - mesh.points[v[i]];
            normals[fan] += degrees_between(a, b) * unit_or(area_vector(mesh, fans, f), Vec<3>{});
        }
        normals[fan] = unit_or(normals[fan], Vec<3>{});
    }
    return normals;
}

void add_fans(const LinearMesh<3>& mesh, const Fans& fans, std::span<const Vec<3>> normals,
              const InspectionLimits& limits, std::vector<LocatedWarning<3>>& out) {
    constexpr double even = 0.7;  // at a cone's tip, each facet's angle with the fan's normal is at least this share of
                                  // the largest such angle
    for (std::size_t fan = 0; fan < fans.size(); ++fan) {
        double least = 180, most = 0;
        for (const FacetId f : fans.facets[fan]) {
            const double turn = degrees_between(area_vector(mesh, fans, f), normals[fan]);
            least = std::fmin(least, turn);
            most = std::fmax(most, turn);
        }
        if (most < limits.normals) continue;
        const auto facets = fans.facets[fan];
        out.push_back({least > even * most ? GeometryWarning::tip : GeometryWarning::spread_normals,
                       most,
                       mesh.points[fans.vertices[fan]],
                       {fans.vertices[fan]},
                       {facets.begin(), facets.end()}});
    }
}

void add_facets(const LinearMesh<3>& mesh, const Fans& fans, std::span<const Vec<3>> normals,
                const InspectionLimits& limits, std::vector<LocatedWarning<3>>& out) {
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const Vec<3> own = area_vector(mesh, fans, FacetId(f));
        Vec<3> mean, centre;
        for (std::size_t i = 0; i < 3; ++i) {
            mean += normals[fans.of_facets[f][i]];
            centre += mesh.points[mesh.facets.vertices[f][i]] / 3;
        }
        const double turn = degrees_between(own, mean);
        if (turn < limits.normals) continue;
        const auto& v = mesh.facets.vertices[f];
        out.push_back({GeometryWarning::turned_facet, turn, centre, {v.begin(), v.end()}, {FacetId(f)}});
    }
}

template <int D>
Outcome<std::vector<LocatedWarning<D>>> find_warnings(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                      const Features<D>& features, const std::vector<Hinge<D>>& hinges,
                                                      const InspectionLimits& limits, const Execution& execution) {
    std::vector<LocatedWarning<D>> out;
    add_turns(mesh, hinges, limits, out);
    if constexpr (D == 3) {
        const auto shells = facet_shells(edges, without_progress(execution));
        if (!shells) return fail(shells.error());
        const auto fans = find_fans(mesh, edges, features, *shells, execution);
        if (!fans) return fail(fans.error());
        const auto normals = normals_of(mesh, *fans);
        add_fans(mesh, *fans, normals, limits, out);
        add_facets(mesh, *fans, normals, limits, out);
    }
    const auto place = [](const LocatedWarning<D>& s) {
        return std::tuple(s.what, s.what == GeometryWarning::mild_ridge ? s.degrees : -s.degrees, s.facets.front());
    };
    std::stable_sort(out.begin(), out.end(),
                     [&](const LocatedWarning<D>& a, const LocatedWarning<D>& b) { return place(a) < place(b); });
    return out;
}

}  // namespace

template <int D>
Outcome<BoundaryInspection<D>> inspect_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const Features<D>& features, const InspectionLimits& limits,
                                                const Execution& execution) {
    if (features.patches.size() != mesh.facets.size() || features.edge_kinds.size() != edges.size())
        return fail(ErrorKind::internal, "the features belong to another mesh");
    return guarded([&]() -> Outcome<BoundaryInspection<D>> {
        BoundaryInspection<D> out;
        const auto around = balls(mesh, part_of(execution, 0, 0.2));
        if (!around) return fail(around.error());
        const auto beside = map_each(part_of(execution, 0.2, 0.4), mesh.facets.size(), [&](std::size_t f) {
            return static_cast<std::uint8_t>(elements_beside(mesh, *around, FacetId(f)));
        });
        if (!beside) return fail(beside.error());
        const auto hinges = find_hinges(mesh, edges, features, execution);
        if (!hinges) return fail(hinges.error());
        add_patches<D>(mesh, features, *beside, out);
        add_hinges(mesh, *hinges, out);
        for (std::size_t v = 0; v < features.vertex_kinds.size(); ++v)
            if (features.vertex_kinds[v] == VertexKind::corner) out.corners.emplace_back(v);
        for (const std::uint8_t n : *beside) {
            out.interface_facets += n == 2 ? 1 : 0;
            out.isolated_facets += n == 0 && mesh.elements.size() > 0 ? 1 : 0;
        }
        if constexpr (D == 3) {
            add_curves(mesh, features, *hinges, out);
            for (const EdgeId e : edges.of_edges)
                out.smooth_listed_edges += features.edge_kinds[e] == EdgeKind::surface ? 1 : 0;
        }
        auto located_warnings = find_warnings(mesh, edges, features, *hinges, limits, part_of(execution, 0.5, 1));
        if (!located_warnings) return fail(located_warnings.error());
        out.located_warnings = std::move(*located_warnings);
        return out;
    });
}

#define CAMBER_INSTANTIATE(D)                                    \
    template Outcome<BoundaryInspection<D>> inspect_boundary<D>( \
        const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, const InspectionLimits&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
