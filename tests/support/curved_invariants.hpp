// Properties of quadratic operations and of meshes with a flat boundary. Each function returns a sentence that
// describes the violation, or an empty string. The includer imports camber.core, camber.bezier and camber.validity
// before (exact_oracle.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bowed.hpp"
#include "curved_operations.hpp"
#include "dynamic_measures.hpp"
#include "exact_oracle.hpp"

import camber.core;
import camber.bezier;
import camber.cavity;
import camber.validity;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// D! times the volume. det J has degree D, so these quadrature rules are exact.
template <int D>
double curved_volume(const QuadraticNodes<D>& nodes) {
    oracle::Nodes<D, double> n;
    for (std::size_t i = 0; i < n.size(); ++i) n[i] = (nodes[i] - nodes[0]).c;
    double vertices = 0;
    double middles = 0;  // 2D: of edges; 3D: of faces
    for (int i = 0; i <= D; ++i) {
        oracle::Whole<D, double> w{}, m;
        w[i] = 1;
        m.fill(1.0 / D);
        m[i] = 0;
        vertices += oracle::determinant_at<D, double>(n, w);
        middles += oracle::determinant_at<D, double>(n, m);
    }
    return D == 2 ? middles / 3 : vertices / 40 + 9 * middles / 40;
}
/// D! times the area of a flat facet: the straight triangle plus the areas between its edges and their chords.
template <int D>
double curved_area(const DynamicMesh<D>& mesh, FacetId f) {
    const auto& v = mesh.facets.vertices[f];
    const Vec<D> side = mesh.points[v[1]] - mesh.points[v[0]];
    if constexpr (D == 2) {
        return norm(side);
    } else {
        Vec<3> area = cross(side, mesh.points[v[2]] - mesh.points[v[0]]);
        const ElementId e = mesh.sides[f][0];
        for (int i = 0; i < 3; ++i) {
            const int a = local_vertex(mesh.elements.vertices[e], v[i]);
            const int b = local_vertex(mesh.elements.vertices[e], v[(i + 1) % 3]);
            const Vec<3>& node = mesh.nodes[mesh.edges_of[e][edge_between<3>[a][b]]].point;
            const Vec<3>& from = mesh.points[v[i]];
            // The area of a parabola segment is 4/3 of the triangle on its chord and vertex (Archimedes); this term is
            // twice that.
            area += (4.0 / 3) * cross(node - from, mesh.points[v[(i + 1) % 3]] - from);
        }
        return norm(area);
    }
}

/// Like `measures`, for curved simplices.
template <int D>
Sizes curved_measures(const DynamicMesh<D>& mesh) {
    Sizes sums;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)))
            sums[{D, mesh.elements.references[e]}] += curved_volume<D>(nodes_of(mesh, ElementId(e)));
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!mesh.is_free(FacetId(f))) sums[{D - 1, mesh.facets.references[f]}] += curved_area(mesh, FacetId(f));
    for (std::size_t l = 0; l < mesh.lines.size(); ++l)
        if (!mesh.is_free(LineId(l))) {
            const auto& [a, b] = mesh.edges[mesh.lines[l]];
            sums[{0, mesh.line_references[l]}] += distance(mesh.points[a], mesh.points[b]);
        }
    return sums;
}
inline std::string curved_size_violation(const Sizes& now, const Sizes& then) {
    constexpr double tolerance = 1e-9;
    if (now.size() != then.size()) return "a reference appeared or disappeared";
    for (const auto& [key, value] : then)
        if (const auto at = now.find(key); at == now.end() || !(std::abs(at->second - value) <= tolerance * value))
            return "the curved size of dimension " + std::to_string(key.first) + ", reference " +
                   std::to_string(key.second) + ", changed by a share of " +
                   std::to_string(at == now.end() ? 1 : at->second / value - 1);
    return "";
}

/// Elements are certified valid; the first `exactly` of them also by exact arithmetic that shares no code with the
/// library.
template <int D>
std::string validity_violation(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements,
                               std::size_t exactly) {
    for (std::size_t i = 0; i < elements.size(); ++i) {
        if (mesh.is_free(elements[i])) continue;
        const NodalSimplex<D> element{nodes_of(mesh, elements[i])};
        if (decide(element, 0) != Verdict::valid) return "an element is not certified";
        if (i < exactly && oracle::answer<D>(element, 0) != oracle::Answer::valid) return "an element is not valid";
    }
    return "";
}

/// Maximum number of edges around a cavity whose nodes may move with it.
inline constexpr int bend_around = 4;

/// Elements outside the cavity keep their nodes. Edges in it that do not touch the point do too, except for at most
/// `bend_around` inner edges.
template <int D>
std::string node_violation(const DynamicMesh<D>& before, const DynamicMesh<D>& after, const TopologyChanges& changes) {
    const VertexId point = changes.points[0];
    std::vector<std::uint8_t> removed(before.elements.size(), 0);
    for (const ElementId e : changes.elements.removed) removed[e.index()] = 1;
    std::vector<std::uint8_t> result(after.edges.size(), 0);
    for (const EdgeId e : changes.edges.created) result[e.index()] = 1;
    const auto same = [&](EdgeId e) { return before.edges[e] == after.edges[e] && before.nodes[e] == after.nodes[e]; };
    for (std::size_t e = 0; e < before.elements.size(); ++e)
        if (removed[e] == 0 && !before.is_free(ElementId(e)) && !std::ranges::all_of(before.edges_of[e], same))
            return "an edge of an element outside the cavity has another curve";
    int following = 0;
    for (std::size_t e = 0; e < before.edges.size(); ++e) {
        if (result[e] != 0 || after.is_free(EdgeId(e)) || after.edges[e][0] == point || after.edges[e][1] == point ||
            same(EdgeId(e)))
            continue;
        if (++following > bend_around) return "too many edges without the point have another curve";
        for (std::size_t i = 0; i < before.elements.size(); ++i) {
            const auto& edges = before.edges_of[ElementId(i)];
            const auto at = std::ranges::find(edges, EdgeId(e));
            if (before.is_free(ElementId(i)) || at == edges.end()) continue;
            if (is_node_fixed(before, ElementId(i), static_cast<int>(at - edges.begin())))
                return "a boundary edge without the point has another curve";
        }
    }
    return "";
}

/// The new elements fill the cavity: the volume of each material is unchanged.
template <int D>
std::string filling_violation(const DynamicMesh<D>& before, const DynamicMesh<D>& after,
                              const TopologyChanges& changes) {
    Sizes removed, created;
    for (const ElementId e : changes.elements.removed)
        removed[{D, before.elements.references[e]}] += curved_volume<D>(nodes_of(before, e));
    for (const ElementId e : changes.elements.created)
        if (!after.is_free(e)) created[{D, after.elements.references[e]}] += curved_volume<D>(nodes_of(after, e));
    return curved_size_violation(created, removed);
}

/// The two edges of a split are the halves of the curve, up to rounding.
template <int D>
std::string split_violation(const DynamicMesh<D>& after, const TopologyChanges& changes, const MeantSplit<D>& split,
                            const Vec<D>& stretch) {
    const VertexId point = changes.points[0];
    const double length = norm(unstretched(split.curve.p02 - split.curve.p20, stretch));
    for (const ElementId e : changes.elements.created) {
        if (after.is_free(e)) continue;
        const auto& vertices = after.elements.vertices[e];
        const int at = local_vertex(vertices, point);
        for (int side = 0; side < 2; ++side)
            if (const int end = local_vertex(vertices, split.ends[side]); at >= 0 && end >= 0) {
                const Vec<D> node = after.nodes[after.edges_of[e][edge_between<D>[at][end]]].point;
                const Vec<D> meant = split.curve.point(side == 0 ? split.t / 2 : (1 + split.t) / 2);
                if (!(norm(unstretched(node - meant, stretch)) <= 1e-9 * length)) return "a split edge left its curve";
            }
    }
    return "";
}

/// Reinserting a vertex at its place does not change the boundary.
template <int D>
std::string boundary_curve_violation(const DynamicMesh<D>& before, const DynamicMesh<D>& after,
                                     const TopologyChanges& changes, const Vec<D>& stretch) {
    for (const ElementId e : changes.elements.created) {
        if (after.is_free(e)) continue;
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const EdgeId edge = after.edges_of[e][k];
            const auto has_facet = [&](int face) {
                return face != local_edges<D>[k][0] && face != local_edges<D>[k][1] && facet_at(after, e, face).valid();
            };
            bool is_of_facet = false;
            for (int face = 0; face <= D; ++face) is_of_facet |= has_facet(face);
            if (!is_of_facet || edge.index() >= before.edges.size() || before.edges[edge] != after.edges[edge])
                continue;
            const auto& [a, b] = after.edges[edge];
            const double off = norm(unstretched(after.nodes[edge].point - before.nodes[edge].point, stretch));
            if (!(off <= 1e-9 * norm(unstretched(after.points[b] - after.points[a], stretch))))
                return "reinsertion of a vertex changed boundary curves";
        }
    }
    return "";
}

}  // namespace camber::testing
