// What holds of a mesh whatever is done to it, and what it keeps. Each law gives a sentence on what breaks it, and
// nothing where it holds: tests and the program `laws` ask the same.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "dynamic_measures.hpp"
#include "meshes.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

/// V − E + F − T of the elements.
template <int D>
std::ptrdiff_t euler(const DynamicMesh<D>& mesh) {
    std::size_t faces = 0;
    std::size_t vertices = 0;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)))
            for (int i = 0; i <= D; ++i) {
                const ElementId other = element_across(mesh, ElementId(e), i);
                faces += !other.valid() || other.index() > e ? 1 : 0;
            }
    for (std::size_t v = 0; v < mesh.points.size(); ++v) vertices += mesh.element_of[v].valid() ? 1 : 0;
    const auto n = [](std::size_t count) { return static_cast<std::ptrdiff_t>(count); };
    if (D == 2) return n(vertices) - n(faces) + n(mesh.element_count());
    return n(vertices) - n(mesh.edge_count()) + n(faces) - n(mesh.element_count());
}

/// Euler's characteristic of what each reference has: materials, surfaces, lines.
using Characteristics = std::map<std::pair<int, Reference>, std::ptrdiff_t>;
template <int D>
Characteristics characteristics(const DynamicMesh<D>& mesh) {
    // Every simplex with all of its faces, by their vertices.
    using Face = std::array<VertexId, D + 1>;
    std::vector<std::tuple<int, Reference, Face>> faces;
    const auto add = [&](const auto& simplex, int dimension, Reference reference) {
        for (unsigned some = 1; some < 1U << simplex.size(); ++some) {
            Face face{};
            std::size_t n = 0;
            for (std::size_t i = 0; i < simplex.size(); ++i)
                if ((some >> i & 1U) != 0) face[n++] = simplex[i];
            std::sort(face.begin(), face.end());  // places that are not taken come last
            faces.emplace_back(dimension, reference, face);
        }
    };
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e))) add(mesh.elements.vertices[e], D, mesh.elements.references[e]);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!mesh.is_free(FacetId(f))) add(mesh.facets.vertices[f], D - 1, mesh.facets.references[f]);
    for (std::size_t l = 0; l < mesh.lines.size(); ++l)
        if (!mesh.is_free(LineId(l))) add(mesh.edges[mesh.lines[l]], 0, mesh.line_references[l]);
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    Characteristics sums;
    for (const auto& [dimension, reference, face] : faces) {
        const auto vertices = std::ranges::count_if(face, [](VertexId v) { return v.valid(); });
        sums[{dimension, reference}] += vertices % 2 == 1 ? 1 : -1;
    }
    return sums;
}

/// What a mesh keeps.
template <int D>
struct Kept {
    Sizes sizes;  ///< of flat domains
    std::ptrdiff_t characteristic = 0;
    Characteristics by_reference;
    std::vector<std::pair<VertexId, Vec<D>>> vertices;  ///< corners, those that are required, those that are held
    std::vector<std::pair<EdgeId, std::array<VertexId, 2>>> lines;
    std::vector<std::pair<FacetId, SimplexVertices<D - 1>>> facets;
    std::vector<std::pair<ElementId, SimplexVertices<D>>> elements;
};
template <int D>
Kept<D> kept_by(const DynamicMesh<D>& mesh) {
    Kept<D> kept{measures(mesh), euler(mesh), characteristics(mesh), {}, {}, {}, {}};
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const auto& [place, marks] = mesh.states[v];
        if (place == VertexPlace::corner || marks.has(Mark::required) || marks.has(Mark::frozen))
            kept.vertices.emplace_back(VertexId(v), mesh.points[v]);
    }
    for (std::size_t l = 0; l < mesh.lines.size(); ++l)
        if (mesh.line_marks[l].has(Mark::required)) kept.lines.emplace_back(mesh.lines[l], mesh.edges[mesh.lines[l]]);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.marks[f].has(Mark::required)) kept.facets.emplace_back(FacetId(f), mesh.facets.vertices[f]);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (mesh.elements.marks[e].has(Mark::required))
            kept.elements.emplace_back(ElementId(e), mesh.elements.vertices[e]);
    return kept;
}

template <int D>
std::string unless_sound(const DynamicMesh<D>& mesh) {
    const auto consistent = check_consistency(mesh, alone);
    return consistent ? "" : describe(consistent.error());
}
template <int D>
std::string unless_euler_holds(const DynamicMesh<D>& mesh, const Kept<D>& kept) {
    return euler(mesh) == kept.characteristic ? "" : "Euler's characteristic is another";
}

/// A surface stays a disc or a sphere or what it was, and so do materials and lines.
template <int D>
std::string unless_parts_stay(const DynamicMesh<D>& mesh, const Kept<D>& kept) {
    const Characteristics now = characteristics(mesh);
    if (now.size() != kept.by_reference.size()) return "a reference came or went";
    for (const auto& [key, value] : kept.by_reference)
        if (const auto at = now.find(key); at == now.end() || at->second != value)
            return "what has dimension " + std::to_string(key.first) + " and reference " + std::to_string(key.second) +
                   " is of another shape: its Euler characteristic is " +
                   std::to_string(at == now.end() ? 0 : at->second) + " and was " + std::to_string(value);
    return "";
}

/// Corners where they were, and what is required with the vertices that it had.
template <int D>
std::string unless_required_stay(const DynamicMesh<D>& mesh, const Kept<D>& kept) {
    for (const auto& [v, place] : kept.vertices)
        if (mesh.is_free(v) || mesh.points[v] != place) return "a corner, or a required vertex, moved or went";
    for (const auto& [edge, vertices] : kept.lines)
        if (mesh.edges[edge] != vertices || !mesh.line_at(edge).valid()) return "a required line went";
    for (const auto& [f, vertices] : kept.facets)
        if (mesh.facets.vertices[f] != vertices) return "a required facet went";
    for (const auto& [e, vertices] : kept.elements)
        if (mesh.elements.vertices[e] != vertices) return "a required element went";
    return "";
}

/// Each edge (2D: vertex) of the boundary's facets has an even number of them.
template <int D>
std::string unless_boundary_is_closed(const DynamicMesh<D>& mesh) {
    std::vector<std::array<VertexId, D - 1>> sides;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.is_free(FacetId(f)) || !mesh.sides[f][0].valid() || mesh.sides[f][1].valid()) continue;
        for (int skip = 0; skip < D; ++skip) {
            std::array<VertexId, D - 1> side;
            for (int i = 0, n = 0; i < D; ++i)
                if (i != skip) side[n++] = mesh.facets.vertices[f][i];
            std::sort(side.begin(), side.end());
            sides.push_back(side);
        }
    }
    std::sort(sides.begin(), sides.end());
    for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
        while (next < sides.size() && sides[next] == sides[i]) ++next;
        if ((next - i) % 2 != 0) return "the boundary is not closed";
    }
    return "";
}

template <int D>
std::string unless_elements_are_positive(const DynamicMesh<D>& mesh) {
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)) && !(volume_of(mesh, mesh.elements.vertices[e]) > 0))
            return "an element is inverted";
    return "";
}

/// Volumes of materials, areas and lengths of each reference.
template <int D>
std::string unless_sizes_stay(const DynamicMesh<D>& mesh, const Kept<D>& kept, double tolerance = 1e-8) {
    const Sizes now = measures(mesh);
    if (now.size() != kept.sizes.size()) return "a reference came or went";
    for (const auto& [key, value] : kept.sizes) {
        const auto at = now.find(key);
        if (at == now.end() || !(std::abs(at->second - value) < tolerance))
            return "the size of dimension " + std::to_string(key.first) + ", reference " + std::to_string(key.second) +
                   ", is " + std::to_string(at == now.end() ? 0 : at->second) + " and was " + std::to_string(value);
    }
    return "";
}

/// Kept up to date, and made anew from the simplices alone, it is the same.
template <int D>
std::string unless_as_made_anew(const DynamicMesh<D>& mesh) {
    const auto [compact, edges, nodes, maps] = must(compacted(mesh, alone));
    const DynamicMesh<D> anew = must(make_dynamic(compact, edges, {}, alone));
    if (anew.edge_count() != mesh.edge_count() || by_places(anew) != by_places(mesh))
        return "made anew it has other simplices";
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (const VertexId now = maps.vertices[VertexId(v)]; now.valid())
            if (anew.states[now].place != mesh.states[v].place) return "made anew a vertex lies elsewhere";
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (const EdgeId now = maps.edges[EdgeId(e)]; now.valid()) {
            const auto& [a, b] = mesh.edges[e];
            const std::array ends{maps.vertices[a], maps.vertices[b]};
            if (anew.edges[now] != std::array{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])})
                return "an edge is mapped to another";
            if (anew.line_at(now).valid() != mesh.line_at(EdgeId(e)).valid()) return "made anew a line is none";
        }
    return "";
}

/// Changes as they are told, against what is there before and after.
template <int D>
std::string unless_told(const DynamicMesh<D>& before, const DynamicMesh<D>& after, const TopologyChanges& changes) {
    const auto fits = [](const auto& ids, std::size_t now, std::size_t then) {
        return now + ids.removed.size() == then + ids.created.size();
    };
    if (!fits(changes.vertices, after.vertex_count(), before.vertex_count()) ||
        !fits(changes.edges, after.edge_count(), before.edge_count()) ||
        !fits(changes.lines, after.line_count(), before.line_count()) ||
        !fits(changes.facets, after.facet_count(), before.facet_count()) ||
        !fits(changes.elements, after.element_count(), before.element_count()))
        return "changes are told that are not those of the counts";
    std::vector<std::uint8_t> touched(after.elements.size(), 0);
    for (const ElementId e : changes.elements.removed) touched[e.index()] = 1;
    for (const ElementId e : changes.elements.created) touched[e.index()] = 1;
    for (std::size_t e = 0; e < before.elements.size(); ++e)
        if (touched[e] == 0 && before.elements.vertices[e] != after.elements.vertices[e])
            return "an element changed that is not told of";
    return "";
}

/// Of topology; and, for flat domains, of geometry as well.
template <int D>
std::string unless_topology_holds(const DynamicMesh<D>& mesh, const Kept<D>& kept) {
    for (const std::string& broken : {unless_sound(mesh), unless_euler_holds(mesh, kept),
                                      unless_boundary_is_closed(mesh), unless_required_stay(mesh, kept)})
        if (!broken.empty()) return broken;
    return "";
}
template <int D>
std::string unless_all_holds(const DynamicMesh<D>& mesh, const Kept<D>& kept) {
    for (const std::string& broken :
         {unless_topology_holds(mesh, kept), unless_parts_stay(mesh, kept), unless_elements_are_positive(mesh),
          unless_sizes_stay(mesh, kept), unless_as_made_anew(mesh)})
        if (!broken.empty()) return broken;
    return "";
}

}  // namespace camber::testing
