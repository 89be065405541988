#pragma once
// Builds the reference field from values of camber.core and camber.metric. The includer imports the modules before it.
#include <cstddef>

#include "back_field.hpp"

namespace paper {

[[nodiscard]] inline BackField field_of(const camber::LinearMesh<3>& mesh, const camber::Neighbours<3>& across,
                                        const camber::Column<camber::LogMetric<3>>& log_metrics) {
    BackField field;
    field.vertices.reserve(mesh.points.size());
    field.elements.reserve(mesh.elements.size());
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        field.vertices.push_back({{mesh.points[v].c}, {log_metrics[v].l.c}});
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        BackElement element{};
        for (std::size_t i = 0; i < 4; ++i) {
            element.vertices[i] = mesh.elements.vertices[e][i].value;
            element.neighbours[i] = across[e][i].value;
        }
        field.elements.push_back(element);
    }
    return field;
}

}  // namespace paper
