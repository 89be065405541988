// Moves boundary vertices onto the model.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.validity;
import camber.surface;
import :parts;

namespace camber {

namespace {

/// Largest move to a model vertex, as a share of an edge's length.
constexpr double vertex_reach = 0.5;

class Targets {
  public:
    Targets(const CadModel& model, const CadAssociation& association, const LinearMesh<3>& mesh,
            const Geometry<3>& geometry)
        : model_(model), association_(association), mesh_(mesh), geometry_(geometry) {}

    /// Returns the target of a vertex. Empty if none of its facets is on the model, or if its model entity is unknown.
    [[nodiscard]] std::optional<Vec<3>> operator()(std::span<const FacetId> facets, const Vec<3>& p) const {
        const auto faces = faces_of(association_, facets);
        if (faces.empty()) return std::nullopt;
        const auto corners = facet_site(mesh_, facets.front()).corners;
        const double near = match_tolerance * distance(corners[0], corners[1]);
        const bool is_curve_end =
            std::any_of(facets.begin(), facets.end(), [&](FacetId f) { return association_.faces[f] == no_face; });
        if (faces.size() == 1) {
            if (is_curve_end) return at_rim(faces, facets, p, near);
            return closest_on_virtual_face(model_, faces[0], p).foot.point;
        }
        if (faces.size() == 2 && is_curve_end)
            if (const auto vertex = vertex_between(model_, faces, p))
                if (distance(model_.vertex(*vertex), p) <= near) return model_.vertex(*vertex);
        return at_junction(faces, p, near);
    }

  private:
    [[nodiscard]] std::optional<Vec<3>> at_junction(std::span<const std::size_t> faces, const Vec<3>& p,
                                                    double near) const {
        const Junction at = junction_at_vertex(model_, faces, p, {near, near});
        switch (at.on) {
            case Junction::On::face: return closest_on_virtual_face(model_, at.number, p).foot.point;
            case Junction::On::edge: return closest_on_edge(model_, at.number, p).point;
            case Junction::On::vertex: {
                if (at.distance <= near) return model_.vertex(at.number);
                // The vertex may lie inside an edge that has more than two faces.
                const auto edge = edge_between(model_, faces, std::span(&p, 1));
                const auto foot = edge ? std::optional(closest_on_edge(model_, *edge, p)) : std::nullopt;
                if (foot && foot->distance < 0.5 * at.distance) return foot->point;
                if (at.distance <= vertex_reach / match_tolerance * near) return model_.vertex(at.number);
                return std::nullopt;
            }
            case Junction::On::nothing: return std::nullopt;
        }
        return std::nullopt;
    }
    [[nodiscard]] std::optional<Vec<3>> at_rim(std::span<const std::size_t> face, std::span<const FacetId> facets,
                                               const Vec<3>& p, double near) const {
        EdgeSite<3> site{{}, EdgeKind::ridge, {p, p}, {}};
        bool meets = false;
        for (const FacetId f : facets) {
            const bool is_unassociated = association_.faces[f] == no_face;
            if (!geometry_->prescribes(mesh_.facets.references[f])) continue;
            site.facets.push_back(facet_site(mesh_, f));
            meets = meets || is_unassociated;
        }
        if (meets) return geometry_->on_edge(site, p).point;
        const auto edge = edge_between(model_, face, std::span(&p, 1));
        const auto rim = edge ? std::optional(closest_on_edge(model_, *edge, p).point) : std::nullopt;
        return rim && distance(*rim, p) <= near ? rim : closest_on_face(model_, face[0], p).point;
    }

    const CadModel& model_;
    const CadAssociation& association_;
    const LinearMesh<3>& mesh_;
    const Geometry<3>& geometry_;
};

class TargetsInPlane {
  public:
    TargetsInPlane(const CadModel& model, const CadAssociation& association, const LinearMesh<2>& mesh,
                   const Geometry<2>&)
        : model_(model), association_(association), mesh_(mesh) {}

    [[nodiscard]] std::optional<Vec<2>> operator()(std::span<const FacetId> facets, const Vec<2>& p) const {
        const auto curves = faces_of(association_, facets);
        if (curves.empty()) return std::nullopt;
        const auto corners = facet_site(mesh_, facets.front()).corners;
        const double length = distance(corners[0], corners[1]);
        const bool is_curve_end = curves.size() == 1 && unassociated_faces(facets);
        const auto vertex = is_curve_end ? nearest_end(curves[0], p) : end_between(model_, curves, p);
        const double reach = (is_curve_end ? match_tolerance : vertex_reach) * length;
        const VirtualFaces& groups = model_.parts().virtual_curves;
        const bool is_smooth = std::all_of(curves.begin(), curves.end(),
                                           [&](std::size_t curve) { return groups.are_joined(curve, curves[0]); });
        if (vertex && distance(vertex_in_plane(model_, *vertex), p) <= (is_smooth ? match_tolerance * length : reach))
            return vertex_in_plane(model_, *vertex);
        if (!is_smooth) return std::nullopt;
        return closest_on_virtual_face(model_, *nearest_curve(model_, curves, p), p).foot.point;
    }

  private:
    [[nodiscard]] bool unassociated_faces(std::span<const FacetId> facets) const {
        return std::any_of(facets.begin(), facets.end(), [&](FacetId f) { return association_.faces[f] == no_face; });
    }
    [[nodiscard]] std::optional<std::size_t> nearest_end(std::size_t curve, const Vec<2>& p) const {
        const auto& ends = model_.parts().kernel->edges[curve].vertices;
        const auto nearest = std::min_element(ends.begin(), ends.end(), [&](std::size_t a, std::size_t b) {
            return distance(vertex_in_plane(model_, a), p) < distance(vertex_in_plane(model_, b), p);
        });
        return nearest == ends.end() ? std::nullopt : std::optional(*nearest);
    }

    const CadModel& model_;
    const CadAssociation& association_;
    const LinearMesh<2>& mesh_;
};

template <int D>
using TargetsOf = std::conditional_t<D == 2, TargetsInPlane, Targets>;

/// Moves of vertices to their targets. `shares`: executed share of each move, from 0 (fixed) to 1.
template <int D>
struct MovesOntoModel {
    const LinearMesh<D>& mesh;
    Buffer<Vec<D>> targets;
    Buffer<double> shares;

    [[nodiscard]] Vec<D> at(VertexId v) const {
        const double share = shares[v.index()];
        const Vec<D>& from = mesh.points[v];
        if (share == 0) return from;
        return share == 1 ? targets[v.index()] : from + share * (targets[v.index()] - from);
    }
    template <std::size_t N>
    [[nodiscard]] bool is_moved(const std::array<VertexId, N>& vertices) const {
        return std::any_of(vertices.begin(), vertices.end(), [&](VertexId v) { return shares[v.index()] != 0; });
    }
};

constexpr double preserved_share = 0.2;

template <int D>
bool is_sound(const MovesOntoModel<D>& moves, const SimplexVertices<D>& element) {
    std::array<Vec<D>, D + 1> before, after;
    for (std::size_t i = 0; i <= D; ++i) {
        before[i] = moves.mesh.points[element[i]];
        after[i] = moves.at(element[i]);
    }
    const double volume = signed_volume<D>(before);
    return volume <= 0 || signed_volume<D>(after) >= preserved_share * volume;
}

Vec<3> area_vector(const std::array<Vec<3>, 3>& c) { return cross(c[1] - c[0], c[2] - c[0]); }
Vec<2> area_vector(const std::array<Vec<2>, 2>& c) { return c[1] - c[0]; }

template <int D>
bool is_sound_facet(const MovesOntoModel<D>& moves, const SimplexVertices<D - 1>& facet) {
    std::array<Vec<D>, D> before, after;
    for (std::size_t i = 0; i < D; ++i) {
        before[i] = moves.mesh.points[facet[i]];
        after[i] = moves.at(facet[i]);
    }
    const Vec<D> normal = area_vector(before);
    return dot(normal, area_vector(after)) >= preserved_share * dot(normal, normal);
}

template <int D, class Simplices, class IsSound>
Outcome<std::vector<std::size_t>> flattened(const MovesOntoModel<D>& moves, const Simplices& simplices, IsSound&& sound,
                                            const Execution& execution) {
    const auto marks = map_each(execution, simplices.size(), [&](std::size_t s) -> std::uint8_t {
        return moves.is_moved(simplices[s]) && !sound(moves, simplices[s]) ? 1 : 0;
    });
    if (!marks) return fail(marks.error());
    std::vector<std::size_t> found;
    for (std::size_t s = 0; s < marks->size(); ++s)
        if ((*marks)[s] != 0) found.push_back(s);
    return found;
}

template <int D>
Outcome<Done> limit_moves(MovesOntoModel<D>& moves, const Execution& execution) {
    constexpr int halvings = 6;
    for (int round = 0;; ++round) {
        const auto elements = flattened(moves, moves.mesh.elements.vertices, is_sound<D>, execution);
        if (!elements) return fail(elements.error());
        const auto facets = flattened(moves, moves.mesh.facets.vertices, is_sound_facet<D>, execution);
        if (!facets) return fail(facets.error());
        if (elements->empty() && facets->empty()) return Done{};
        std::vector<VertexId> constrained;
        for (const std::size_t e : *elements)
            for (const VertexId v : moves.mesh.elements.vertices[e]) constrained.push_back(v);
        for (const std::size_t f : *facets)
            for (const VertexId v : moves.mesh.facets.vertices[f]) constrained.push_back(v);
        std::sort(constrained.begin(), constrained.end());
        constrained.erase(std::unique(constrained.begin(), constrained.end()), constrained.end());
        for (const VertexId v : constrained)
            moves.shares[v.index()] = round < halvings ? moves.shares[v.index()] / 2 : 0;
    }
}

template <int D>
VerticesOnModel<D> moved(const MovesOntoModel<D>& moves, const Buffer<std::uint8_t>& is_off) {
    VerticesOnModel<D> out;
    Buffer<Vec<D>> points(moves.mesh.points.begin(), moves.mesh.points.end());
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (is_off[v] == 0) continue;
        points[v] = moves.at(VertexId(v));
        const double way = distance(points[v], moves.mesh.points[VertexId(v)]);
        out.moved += way > 0 ? 1 : 0;
        out.constrained += moves.shares[v] < 1 ? 1 : 0;
        if (way <= out.largest) continue;
        out.largest = way;
        out.farthest = VertexId(v);
    }
    out.points = std::move(points);
    return out;
}

}  // namespace

template <int D>
Outcome<VerticesOnModel<D>> vertices_onto(const CadModel& model, const CadAssociation& association,
                                          const LinearMesh<D>& mesh, const Geometry<D>& geometry,
                                          const Execution& execution) {
    constexpr double off = 1e-12;  // relative to the model's size; smaller distances are rounding
    return guarded([&]() -> Outcome<VerticesOnModel<D>> {
        const auto around = facet_balls(mesh, without_progress(execution));
        if (!around) return fail(around.error());
        const auto required = required_vertices(mesh);
        const TargetsOf<D> target(model, association, mesh, geometry);
        auto targets = map_each(part_of(execution, 0, 0.8), mesh.points.size(), [&](std::size_t v) -> Vec<D> {
            const Vec<D>& p = mesh.points[VertexId(v)];
            if (required[v] != 0 || (*around)[v].empty()) return p;
            const auto found = target((*around)[v], p);
            return found && distance(*found, p) > off * model.parts().size ? *found : p;
        });
        if (!targets) return fail(targets.error());
        Buffer<std::uint8_t> is_off(targets->size(), 0);
        MovesOntoModel<D> moves{mesh, std::move(*targets), Buffer<double>(is_off.size(), 0.0)};
        for (std::size_t v = 0; v < is_off.size(); ++v) {
            is_off[v] = moves.targets[v] != mesh.points[VertexId(v)] ? 1 : 0;
            moves.shares[v] = is_off[v];
        }
        if (auto constrained = limit_moves(moves, without_progress(execution)); !constrained)
            return fail(constrained.error());
        return moved(moves, is_off);
    });
}

template <int D>
Outcome<Done> check_vertices(const CadAssociation& association, CadVertices vertices) {
    if (!association.fit_error) return Done{};
    const auto& [is_edge, number, fit] = *association.fit_error;
    const std::string name = (is_edge || D == 2 ? "CAD edge " : "CAD face ") + std::to_string(number + 1);
    const char* const remedy =
        vertices == CadVertices::move
            ? "moving the vertices onto the model would make elements flat. Generate a mesh of this model"
            : "give the CAD model from which the mesh was generated, or move the vertices onto this model: "
              "--cad-vertices move";
    return fail(ErrorKind::input, fit.text(name), {}, Entity{"vertex", fit.farthest.index() + 1}, remedy);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<VerticesOnModel<D>> vertices_onto<D>(const CadModel&, const CadAssociation&,                      \
                                                          const LinearMesh<D>&, const Geometry<D>&, const Execution&); \
    template Outcome<Done> check_vertices<D>(const CadAssociation&, CadVertices);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
