module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>
module camber.adapt:boundary_moves;
import camber.core;
import camber.cavity;
import camber.operation;
import camber.surface;

/// Where vertices of the boundary may go.
namespace camber {

/// Whether a vertex may go this step without any of its facets leaving its plane: then its surface stays as it is.
template <int D>
[[nodiscard]] bool keeps_planes(const DynamicMesh<D>& mesh, const std::vector<FacetId>& facets, const Vec<D>& step) {
    constexpr double parallel = 1e-10;  // coordinates have rounding, facets may be thin
    return std::ranges::all_of(facets, [&](FacetId f) {
        if (mesh.is_at_infinity(f)) return true;
        const Vec<D> n = facet_normal(corners_of(mesh, f));
        return std::abs(dot(n, step)) <= parallel * norm(n) * norm(step);
    });
}

/// Whether the lines at a vertex are one straight line along a step.
[[nodiscard]] inline bool keeps_lines(const DynamicMesh<3>& mesh, const std::vector<LineId>& lines,
                                      const Vec<3>& step) {
    constexpr double parallel = 1e-9;
    return std::ranges::all_of(lines, [&](LineId line) {
        const auto& [a, b] = mesh.edges[mesh.lines[line]];
        const Vec<3> along = mesh.points[b] - mesh.points[a];
        return norm(cross(along, step)) <= parallel * norm(along) * norm(step);
    });
}

/// A place, and where on the geometry that is.
template <int D>
struct BoundaryPlace {
    Vec<D> point;
    GeometryPlace lies = {};
};
template <int D>
[[nodiscard]] BoundaryPlace<D> boundary_place(const SurfacePoint<D>& on) {
    return {on.point, place_of(on)};
}

/// Of a surface: to the geometry, or, where that has none there, in the plane of all of its facets.
template <int D>
[[nodiscard]] std::optional<BoundaryPlace<D>> place_on_surface(const AdaptationGoal<D>& goal,
                                                               const DynamicMesh<D>& mesh, const Cavity<D>& around,
                                                               const Vec<D>& here, const GeometryEntity& known,
                                                               const Vec<D>& wanted) {
    const FacetId f = around.facets.front();
    if (goal.geometry && (*goal.geometry)->has_surface_at(site_of(mesh, f)))
        return boundary_place(on_geometry_at_facet(goal, mesh, f, known, wanted));
    const Plane<D> plane{here, normalised(facet_normal(corners_of(mesh, f)))};
    const Vec<D> place = slid_within(plane, here, wanted - here);
    if (!keeps_planes(mesh, around.facets, place - here)) return {};
    return BoundaryPlace<D>{place};
}

/// Of a line: along that one of its two edges which the step goes with, and from there to the geometry; where that is
/// no other place, only along what is straight.
[[nodiscard]] inline std::optional<BoundaryPlace<3>> place_on_line(const AdaptationGoal<3>& goal,
                                                                   const DynamicMesh<3>& mesh, const Cavity<3>& around,
                                                                   VertexId v, const Vec<3>& wanted) {
    if (around.lines.size() != 2) return {};
    const Vec<3> here = mesh.points[v];
    const Vec<3> step = wanted - here;
    constexpr double most = 0.5;  // of the edge
    std::optional<BoundaryPlace<3>> place;
    double farthest = 0;
    for (const LineId line : around.lines) {
        const EdgeId edge = mesh.lines[line];
        const auto& [a, b] = mesh.edges[edge];
        const Vec<3> along = mesh.points[a == v ? b : a] - here;
        const double share = std::min(dot(step, along) / norm_squared(along), most);
        if (!(share * norm(along) > farthest)) continue;
        farthest = share * norm(along);
        const Vec<3> on_chord = here + share * along;
        std::vector<FacetId> facets;
        facets_with(mesh, around.elements, edge, facets);
        place = boundary_place(on_geometry_at_edge(goal, mesh, edge, facets, on_chord));
        constexpr double rounding = 1e-12;
        const bool is_straight = distance(place->point, on_chord) <= rounding * norm(along);
        if (is_straight &&
            !(keeps_planes(mesh, around.facets, on_chord - here) && keeps_lines(mesh, around.lines, on_chord - here)))
            place.reset();
    }
    return place;
}

/// Where a vertex goes that requests to be at `wanted`; nothing where it may not, or nobody knows where its surface is.
/// `known`: what it lies on, if that is known.
template <int D>
[[nodiscard]] std::optional<BoundaryPlace<D>> place_for(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh,
                                                        const Cavity<D>& around, VertexId v,
                                                        const GeometryEntity& known, const Vec<D>& wanted) {
    switch (mesh.states[v].place) {
        case VertexPlace::inside: return BoundaryPlace<D>{wanted};
        case VertexPlace::surface: return place_on_surface(goal, mesh, around, mesh.points[v], known, wanted);
        case VertexPlace::line:
            if constexpr (D == 3) return place_on_line(goal, mesh, around, v, wanted);
            return {};
        case VertexPlace::corner:
        case VertexPlace::infinity: return {};
    }
    return {};
}

}  // namespace camber
