// Invariants of a mesh under operations. Each function returns a sentence that describes the violation, or an empty
// string. Tests and the program `invariants` use them.
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

/// Euler characteristic V − E + F − T of the elements.
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

/// Euler characteristics of materials, surfaces and lines by reference.
using Characteristics = std::map<std::pair<int, Reference>, std::ptrdiff_t>;
template <int D>
Characteristics characteristics(const DynamicMesh<D>& mesh) {
    // All faces of every simplex, as sorted vertices.
    using Face = std::array<VertexId, D + 1>;
    std::vector<std::tuple<int, Reference, Face>> faces;
    const auto add = [&](const auto& simplex, int dimension, Reference reference) {
        for (unsigned some = 1; some < 1U << simplex.size(); ++some) {
            Face face{};
            std::size_t n = 0;
            for (std::size_t i = 0; i < simplex.size(); ++i)
                if ((some >> i & 1U) != 0) face[n++] = simplex[i];
            std::sort(face.begin(), face.end());  // unused entries are last
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

/// Invariants of a mesh.
template <int D>
struct Invariants {
    Sizes sizes;  ///< constant for flat domains
    std::ptrdiff_t characteristic = 0;
    Characteristics by_reference;
    std::vector<std::pair<VertexId, Vec<D>>> vertices;  ///< corners, required and frozen vertices
    std::vector<std::pair<EdgeId, std::array<VertexId, 2>>> lines;
    std::vector<std::pair<FacetId, SimplexVertices<D - 1>>> facets;
    std::vector<std::pair<ElementId, SimplexVertices<D>>> elements;
};
template <int D>
Invariants<D> invariants_of(const DynamicMesh<D>& mesh) {
    Invariants<D> invariants{measures(mesh), euler(mesh), characteristics(mesh), {}, {}, {}, {}};
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const auto& [place, marks] = mesh.states[v];
        if (place == VertexPlace::corner || marks.has(Mark::required) || marks.has(Mark::frozen))
            invariants.vertices.emplace_back(VertexId(v), mesh.points[v]);
    }
    for (std::size_t l = 0; l < mesh.lines.size(); ++l)
        if (mesh.line_marks[l].has(Mark::required))
            invariants.lines.emplace_back(mesh.lines[l], mesh.edges[mesh.lines[l]]);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.marks[f].has(Mark::required))
            invariants.facets.emplace_back(FacetId(f), mesh.facets.vertices[f]);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (mesh.elements.marks[e].has(Mark::required))
            invariants.elements.emplace_back(ElementId(e), mesh.elements.vertices[e]);
    return invariants;
}

template <int D>
std::string consistency_violation(const DynamicMesh<D>& mesh) {
    const auto consistent = check_consistency(mesh, one_thread);
    return consistent ? "" : describe(consistent.error());
}
template <int D>
std::string euler_violation(const DynamicMesh<D>& mesh, const Invariants<D>& invariants) {
    return euler(mesh) == invariants.characteristic ? "" : "the Euler characteristic changed";
}

/// The Euler characteristics of surfaces, materials and lines are unchanged.
template <int D>
std::string characteristics_violation(const DynamicMesh<D>& mesh, const Invariants<D>& invariants) {
    const Characteristics now = characteristics(mesh);
    if (now.size() != invariants.by_reference.size()) return "a reference appeared or disappeared";
    for (const auto& [key, value] : invariants.by_reference)
        if (const auto at = now.find(key); at == now.end() || at->second != value)
            return "the Euler characteristic of dimension " + std::to_string(key.first) + ", reference " +
                   std::to_string(key.second) + ", changed from " + std::to_string(value) + " to " +
                   std::to_string(at == now.end() ? 0 : at->second);
    return "";
}

/// Corners and required vertices have not moved; required simplices have the same vertices.
template <int D>
std::string required_violation(const DynamicMesh<D>& mesh, const Invariants<D>& invariants) {
    for (const auto& [v, place] : invariants.vertices)
        if (mesh.is_free(v) || mesh.points[v] != place) return "a corner or required vertex moved or was removed";
    for (const auto& [edge, vertices] : invariants.lines)
        if (mesh.edges[edge] != vertices || !mesh.line_at(edge).valid()) return "a required line was removed";
    for (const auto& [f, vertices] : invariants.facets)
        if (mesh.facets.vertices[f] != vertices) return "a required facet was removed";
    for (const auto& [e, vertices] : invariants.elements)
        if (mesh.elements.vertices[e] != vertices) return "a required element was removed";
    return "";
}

/// Each edge (2D: vertex) of boundary facets belongs to an even number of them.
template <int D>
std::string closure_violation(const DynamicMesh<D>& mesh) {
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
std::string orientation_violation(const DynamicMesh<D>& mesh) {
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)) && !(volume_of(mesh, mesh.elements.vertices[e]) > 0))
            return "an element is inverted";
    return "";
}

/// Volumes of materials, areas and lengths by reference are unchanged.
template <int D>
std::string size_violation(const DynamicMesh<D>& mesh, const Invariants<D>& invariants, double tolerance = 1e-8) {
    const Sizes now = measures(mesh);
    if (now.size() != invariants.sizes.size()) return "a reference appeared or disappeared";
    for (const auto& [key, value] : invariants.sizes) {
        const auto at = now.find(key);
        if (at == now.end() || !(std::abs(at->second - value) < tolerance))
            return "the size of dimension " + std::to_string(key.first) + ", reference " + std::to_string(key.second) +
                   ", changed from " + std::to_string(value) + " to " +
                   std::to_string(at == now.end() ? 0 : at->second);
    }
    return "";
}

/// The mesh equals the mesh rebuilt from its simplices.
template <int D>
std::string rebuild_violation(const DynamicMesh<D>& mesh) {
    const auto [compact, edges, nodes, maps] = must(compacted(mesh, one_thread));
    const DynamicMesh<D> rebuilt = must(make_dynamic(compact, edges, {}, one_thread));
    if (rebuilt.edge_count() != mesh.edge_count() || by_places(rebuilt) != by_places(mesh))
        return "the rebuilt mesh has other simplices";
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (const VertexId now = maps.vertices[VertexId(v)]; now.valid())
            if (rebuilt.states[now].place != mesh.states[v].place)
                return "a vertex of the rebuilt mesh is on another geometric entity";
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (const EdgeId now = maps.edges[EdgeId(e)]; now.valid()) {
            const auto& [a, b] = mesh.edges[e];
            const std::array ends{maps.vertices[a], maps.vertices[b]};
            if (rebuilt.edges[now] != std::array{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])})
                return "an edge is mapped to another edge";
            if (rebuilt.line_at(now).valid() != mesh.line_at(EdgeId(e)).valid())
                return "the rebuilt mesh has other lines";
        }
    return "";
}

/// The reported changes agree with the mesh before and after.
template <int D>
std::string changes_violation(const DynamicMesh<D>& before, const DynamicMesh<D>& after,
                              const TopologyChanges& changes) {
    const auto fits = [](const auto& ids, std::size_t now, std::size_t then) {
        return now + ids.removed.size() == then + ids.created.size();
    };
    if (!fits(changes.vertices, after.vertex_count(), before.vertex_count()) ||
        !fits(changes.edges, after.edge_count(), before.edge_count()) ||
        !fits(changes.lines, after.line_count(), before.line_count()) ||
        !fits(changes.facets, after.facet_count(), before.facet_count()) ||
        !fits(changes.elements, after.element_count(), before.element_count()))
        return "the reported changes disagree with the entity counts";
    std::vector<std::uint8_t> touched(after.elements.size(), 0);
    for (const ElementId e : changes.elements.removed) touched[e.index()] = 1;
    for (const ElementId e : changes.elements.created) touched[e.index()] = 1;
    for (std::size_t e = 0; e < before.elements.size(); ++e)
        if (touched[e] == 0 && before.elements.vertices[e] != after.elements.vertices[e])
            return "an element changed that is not reported";
    return "";
}

/// Checks topology; `invariant_violation` also checks the geometry of flat domains.
template <int D>
std::string topology_violation(const DynamicMesh<D>& mesh, const Invariants<D>& invariants) {
    for (const std::string& broken : {consistency_violation(mesh), euler_violation(mesh, invariants),
                                      closure_violation(mesh), required_violation(mesh, invariants)})
        if (!broken.empty()) return broken;
    return "";
}
template <int D>
std::string invariant_violation(const DynamicMesh<D>& mesh, const Invariants<D>& invariants) {
    for (const std::string& broken :
         {topology_violation(mesh, invariants), characteristics_violation(mesh, invariants),
          orientation_violation(mesh), size_violation(mesh, invariants), rebuild_violation(mesh)})
        if (!broken.empty()) return broken;
    return "";
}

}  // namespace camber::testing
