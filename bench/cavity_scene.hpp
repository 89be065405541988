// A mesh before and after an operation, as JSON for docs/pictures/draw_cavities.py.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.cavity;

namespace camber {

template <class T>
T must(Outcome<T> outcome) {
    if (outcome) return std::move(*outcome);
    std::fprintf(stderr, "%s\n", describe(outcome.error()).c_str());
    std::exit(1);
}

/// Prints the ends and the node of each edge.
template <int D>
void print_nodes(const DynamicMesh<D>& mesh) {
    std::printf(",\n  \"nodes\": [");
    bool first = true;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (mesh.is_free(EdgeId(e))) continue;
        const auto& [a, b] = mesh.edges[e];
        std::printf("%s[%u, %u", first ? "" : ", ", a.value, b.value);
        for (const double x : mesh.nodes[e].point.c) std::printf(", %.6f", x);
        std::printf("]");
        first = false;
    }
    std::printf("]");
}

template <int D>
void print_mesh(const char* name, const DynamicMesh<D>& mesh, const std::vector<ElementId>& marked) {
    std::printf(" \"%s\": {\"points\": [", name);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        std::printf("%s[", v == 0 ? "" : ", ");
        for (int i = 0; i < D; ++i) std::printf("%s%.6f", i == 0 ? "" : ", ", mesh.points[v][i]);
        std::printf("]");
    }
    std::printf("],\n  \"elements\": [");
    bool first = true;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (mesh.is_free(ElementId(e))) continue;
        std::printf("%s[", first ? "" : ", ");
        for (const VertexId v : mesh.elements.vertices[e]) std::printf("%u, ", v.value);
        std::printf("%d]", std::ranges::find(marked, ElementId(e)) != marked.end() ? 1 : 0);
        first = false;
    }
    std::printf("]");
    if (mesh.is_curved()) print_nodes(mesh);
    std::printf("}");
}

/// Prints a mesh before and after a patch. The last number of an element is 1 if it belongs to the cavity or the star.
template <int D>
void print_patch(const char* name, DynamicMesh<D> mesh, const Patch<D>& patch, const char* more) {
    std::printf("%s\"%s\": {%s\n", std::string(name) == "insertion" ? "" : ",\n", name, more);
    print_mesh("before", mesh, patch.removed.elements);
    auto [after, changes] = must(replace_cavities<D>(std::move(mesh), {&patch, 1}));
    std::printf(",\n \"point\": %u,\n", changes.points.front().value);
    print_mesh("after", after, changes.elements.created);
    std::printf("}");
}

}  // namespace camber
