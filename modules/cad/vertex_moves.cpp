module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import camber.validity;
import :parts;

namespace camber {

namespace {

/// Where vertices of the boundary belong.
class Homes {
  public:
    Homes(const CadModel& model, const CadAssociation& association, const LinearMesh<3>& mesh,
          const Geometry<3>& geometry)
        : model_(model), association_(association), mesh_(mesh), geometry_(geometry) {}

    /// Nothing where it has no facet on the model, or where it is not known what it lies on.
    [[nodiscard]] std::optional<Vec<3>> operator()(std::span<const FacetId> facets, const Vec<3>& p) const {
        const auto faces = faces_of(facets);
        if (faces.empty()) return std::nullopt;
        const auto corners = facet_site(mesh_, facets.front()).corners;
        const double near = near_enough * distance(corners[0], corners[1]);
        const bool ends_here =
            std::any_of(facets.begin(), facets.end(), [&](FacetId f) { return association_.faces[f] == no_face; });
        if (faces.size() > 2) return at_vertex(faces, p, near);
        if (faces.size() == 2) {
            const auto end = ends_here ? at_vertex(faces, p, near) : std::nullopt;
            return end ? end : at_edge(faces, p);
        }
        return ends_here ? at_rim(faces, facets, p, near) : closest_on_face(model_, faces[0], p).point;
    }

  private:
    [[nodiscard]] std::vector<std::size_t> faces_of(std::span<const FacetId> facets) const {
        std::vector<std::size_t> faces;
        faces.reserve(facets.size());
        for (const FacetId f : facets)
            if (association_.faces[f] != no_face) faces.push_back(association_.faces[f]);
        std::sort(faces.begin(), faces.end());
        faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
        return faces;
    }
    [[nodiscard]] std::optional<Vec<3>> at_vertex(std::span<const std::size_t> faces, const Vec<3>& p,
                                                  double near) const {
        const auto vertex = vertex_between(model_, faces, p);
        if (!vertex || distance(model_.vertex(*vertex), p) > near) return std::nullopt;
        return model_.vertex(*vertex);
    }
    [[nodiscard]] std::optional<Vec<3>> at_edge(std::span<const std::size_t> faces, const Vec<3>& p) const {
        const auto edge = edge_between(model_, faces, std::span(&p, 1));
        return edge ? std::optional(closest_on_edge(model_, *edge, p).point) : std::nullopt;
    }
    /// At the end of the part that is on the model.
    [[nodiscard]] std::optional<Vec<3>> at_rim(std::span<const std::size_t> face, std::span<const FacetId> facets,
                                               const Vec<3>& p, double near) const {
        EdgeSite<3> site{{}, EdgeKind::ridge, {p, p}, {}};
        bool meets = false;
        for (const FacetId f : facets) {
            const bool is_elsewhere = association_.faces[f] == no_face;
            if (!geometry_->prescribes(mesh_.facets.references[f])) continue;
            site.facets.push_back(facet_site(mesh_, f));
            meets = meets || is_elsewhere;
        }
        if (meets) return geometry_->on_edge(site, p).point;
        const auto rim = at_edge(face, p);
        return rim && distance(*rim, p) <= near ? rim : closest_on_face(model_, face[0], p).point;
    }

    const CadModel& model_;
    const CadAssociation& association_;
    const LinearMesh<3>& mesh_;
    const Geometry<3>& geometry_;
};

/// How far each vertex goes on its way: a share, 0 where it stays.
struct Ways {
    const LinearMesh<3>& mesh;
    Buffer<Vec<3>> homes;
    Buffer<double> shares;

    [[nodiscard]] Vec<3> at(VertexId v) const {
        const double share = shares[v.index()];
        const Vec<3>& from = mesh.points[v];
        if (share == 0) return from;
        return share == 1 ? homes[v.index()] : from + share * (homes[v.index()] - from);
    }
    template <std::size_t N>
    [[nodiscard]] bool is_moved(const std::array<VertexId, N>& vertices) const {
        return std::any_of(vertices.begin(), vertices.end(), [&](VertexId v) { return shares[v.index()] != 0; });
    }
};

constexpr double kept = 0.2;

/// Whether an element keeps a share of its volume; what had none has none to keep.
bool is_sound(const Ways& ways, const SimplexVertices<3>& element) {
    std::array<Vec<3>, 4> before, after;
    for (std::size_t i = 0; i < 4; ++i) {
        before[i] = ways.mesh.points[element[i]];
        after[i] = ways.at(element[i]);
    }
    const double volume = signed_volume<3>(before);
    return volume <= 0 || signed_volume<3>(after) >= kept * volume;
}

/// Whether a facet keeps a share of its area, seen along its normal.
bool is_sound(const Ways& ways, const SimplexVertices<2>& facet) {
    const auto normal = [](const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) { return cross(b - a, c - a); };
    const auto& points = ways.mesh.points;
    const Vec<3> before = normal(points[facet[0]], points[facet[1]], points[facet[2]]);
    const Vec<3> after = normal(ways.at(facet[0]), ways.at(facet[1]), ways.at(facet[2]));
    return dot(before, after) >= kept * dot(before, before);
}

/// The simplices that would be flat or inverted.
template <class Simplices>
Outcome<std::vector<std::size_t>> flattened(const Ways& ways, const Simplices& simplices, const Execution& execution) {
    const auto marks = map_each(execution, simplices.size(), [&](std::size_t s) -> std::uint8_t {
        return ways.is_moved(simplices[s]) && !is_sound(ways, simplices[s]) ? 1 : 0;
    });
    if (!marks) return fail(marks.error());
    std::vector<std::size_t> found;
    for (std::size_t s = 0; s < marks->size(); ++s)
        if ((*marks)[s] != 0) found.push_back(s);
    return found;
}

/// Vertices of what would be flat go half of their ways, and after some rounds none of it; until nothing is.
Outcome<Done> hold_back(Ways& ways, const Execution& execution) {
    constexpr int halvings = 6;
    for (int round = 0;; ++round) {
        const auto elements = flattened(ways, ways.mesh.elements.vertices, execution);
        if (!elements) return fail(elements.error());
        const auto facets = flattened(ways, ways.mesh.facets.vertices, execution);
        if (!facets) return fail(facets.error());
        if (elements->empty() && facets->empty()) return Done{};
        std::vector<VertexId> held;
        for (const std::size_t e : *elements)
            for (const VertexId v : ways.mesh.elements.vertices[e]) held.push_back(v);
        for (const std::size_t f : *facets)
            for (const VertexId v : ways.mesh.facets.vertices[f]) held.push_back(v);
        std::sort(held.begin(), held.end());
        held.erase(std::unique(held.begin(), held.end()), held.end());
        for (const VertexId v : held) ways.shares[v.index()] = round < halvings ? ways.shares[v.index()] / 2 : 0;
    }
}

VerticesOnModel moved(const Ways& ways, Buffer<std::uint8_t> is_off) {
    VerticesOnModel out;
    Buffer<Vec<3>> points(ways.mesh.points.begin(), ways.mesh.points.end());
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (is_off[v] == 0) continue;
        points[v] = ways.at(VertexId(v));
        const double way = distance(points[v], ways.mesh.points[VertexId(v)]);
        out.moved += way > 0 ? 1 : 0;
        out.held += ways.shares[v] < 1 ? 1 : 0;
        if (way <= out.largest) continue;
        out.largest = way;
        out.farthest = VertexId(v);
    }
    out.points = std::move(points);
    return out;
}

}  // namespace

Outcome<VerticesOnModel> vertices_onto(const CadModel& model, const CadAssociation& association,
                                       const LinearMesh<3>& mesh, const Geometry<3>& geometry,
                                       const Execution& execution) {
    constexpr double off = 1e-12;  // of the model's size; what is nearer is there but for rounding
    return guarded([&]() -> Outcome<VerticesOnModel> {
        const auto around = facet_balls(mesh, without_progress(execution));
        if (!around) return fail(around.error());
        const auto required = required_vertices(mesh);
        const Homes home(model, association, mesh, geometry);
        auto homes = map_each(part_of(execution, 0, 0.8), mesh.points.size(), [&](std::size_t v) -> Vec<3> {
            const Vec<3>& p = mesh.points[VertexId(v)];
            if (required[v] != 0 || (*around)[v].empty()) return p;
            const auto found = home((*around)[v], p);
            return found && distance(*found, p) > off * model.parts().size ? *found : p;
        });
        if (!homes) return fail(homes.error());
        Buffer<std::uint8_t> is_off(homes->size(), 0);
        Ways ways{mesh, std::move(*homes), Buffer<double>(is_off.size(), 0.0)};
        for (std::size_t v = 0; v < is_off.size(); ++v) {
            is_off[v] = ways.homes[v] != mesh.points[VertexId(v)] ? 1 : 0;
            ways.shares[v] = is_off[v];
        }
        if (auto held = hold_back(ways, without_progress(execution)); !held) return fail(held.error());
        return moved(ways, std::move(is_off));
    });
}

}  // namespace camber
