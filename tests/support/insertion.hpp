// Cavity of a point inserted into a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "dynamic_measures.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

/// The position of a point: the interior of the simplex that some vertices of an element span. All of them: the element
/// itself; D: a face; one: that vertex.
template <int D>
struct PointSite {
    ElementId element;
    std::array<bool, D + 1> spans{};  ///< true for the local vertices that span the simplex

    [[nodiscard]] int dimension() const { return static_cast<int>(std::ranges::count(spans, true)) - 1; }
};

/// A point counts as on a face if its distance to the face is at most this share of the element's height over it.
inline constexpr double near_share = 1e-9;

/// Returns the site of a point, or nothing if the point lies in no element. Compares volumes in doubles, in all
/// elements.
template <int D>
std::optional<PointSite<D>> locate(const DynamicMesh<D>& mesh, const Vec<D>& point, double near = near_share) {
    std::optional<PointSite<D>> best;
    double highest = -std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (mesh.is_free(ElementId(e))) continue;
        std::array<Vec<D>, D + 1> corners;
        for (int i = 0; i <= D; ++i) corners[i] = mesh.points[mesh.elements.vertices[ElementId(e)][i]];
        const double volume = orientation(corners);
        if (!(volume > 0)) continue;
        std::array<double, D + 1> shares{};
        for (int i = 0; i <= D; ++i) {
            auto part = corners;
            part[i] = point;
            shares[i] = orientation(part) / volume;
        }
        const double least = *std::ranges::min_element(shares);
        if (!(least >= -near && least > highest)) continue;
        highest = least;
        best = PointSite<D>{ElementId(e), {}};
        for (int i = 0; i <= D; ++i) best->spans[i] = shares[i] > near;
    }
    return best;
}

/// Collects the elements on both sides of a face, and the facet on it.
template <int D>
void cavity_of_face(const DynamicMesh<D>& mesh, ElementId e, int face, Cavity<D>& out) {
    out.clear();
    out.elements.push_back(e);
    if (const ElementId other = element_across(mesh, e, face); other.valid()) out.elements.push_back(other);
    if (const FacetId facet = facet_at(mesh, e, face); facet.valid()) out.facets.push_back(facet);
}

/// A point and the cavity of its insertion: the element that contains it; both sides of its face with the facet; or the
/// shell of its edge with facets and line.
template <int D>
struct Insertion {
    Cavity<D> cavity;
    PointSite<D> site;
    VertexPlace place = VertexPlace::inside;  ///< place of the new vertex
    VertexId vertex;  ///< the vertex at the point, if there is one: the cavity is then the vertex's

    [[nodiscard]] bool is_at_vertex() const { return vertex.valid(); }
};

template <int D>
Insertion<D> insertion_at(const DynamicMesh<D>& mesh, const PointSite<D>& site) {
    const auto first = std::ranges::find(site.spans, true) - site.spans.begin();
    const auto second = std::find(site.spans.begin() + first + 1, site.spans.end(), true) - site.spans.begin();
    Insertion<D> out;
    out.site = site;
    switch (site.dimension()) {
        case 0:
            out.vertex = mesh.elements.vertices[site.element][first];
            out.place = mesh.states[out.vertex].place;
            cavity_of_vertex(mesh, out.vertex, out.cavity);
            return out;
        case 1: cavity_of_edge(mesh, site.element, edge_between<D>[first][second], out.cavity); break;
        case D: out.cavity.elements.push_back(site.element); break;
        default:
            cavity_of_face(mesh, site.element,
                           static_cast<int>(std::ranges::find(site.spans, false) - site.spans.begin()), out.cavity);
    }
    if (!out.cavity.facets.empty()) out.place = VertexPlace::surface;
    if (!out.cavity.lines.empty()) out.place = VertexPlace::line;
    return out;
}

/// Returns the insertion at a point, or nothing if the point lies in no element.
template <int D>
std::optional<Insertion<D>> insertion(const DynamicMesh<D>& mesh, const Vec<D>& point) {
    const auto site = locate(mesh, point);
    return site ? std::optional(insertion_at(mesh, *site)) : std::nullopt;
}

}  // namespace camber::testing
