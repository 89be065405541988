// Shell with ten prism layers on its inner sphere: 20 000 tetrahedra, most of them in the layers.
#pragma once

#include <cstddef>

#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.shapes;
import camber.surface;
import camber.curving;

namespace camber::testing {

inline LinearMesh<3> layered_shell() {
    ShellOptions<3> options;
    options.inner_layer = {.count = 10, .first_height = 0.002};
    options.structure = ShellStructure::prisms;
    return must(generate(with_elements(options, 20000), one_thread));
}

/// The shell with all inputs of curving.
struct ShellCase {
    QuadraticMesh<3> mesh = must(elevate(layered_shell(), one_thread));
    Features<3> features = must(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, one_thread));
    const Column<EdgeKind>& kinds = features.edge_kinds;
    Incidence<ElementId> shell = must(shells(mesh.edges, one_thread));
    Incidence<ElementId> ball = must(balls(mesh.linear, one_thread));
    BackMesh<3> back = must(make_back_mesh(
        mesh.linear, ball, Column<LogMetric<3>>(must(natural_log_metrics(mesh.linear, ball, one_thread))), one_thread));

    [[nodiscard]] std::size_t edges() const { return mesh.edges.size(); }
    [[nodiscard]] std::size_t tetrahedra() const { return mesh.linear.elements.size(); }
    /// Nodes of boundary edges projected onto their sphere.
    [[nodiscard]] Column<LagrangeNode<3>> on_spheres() const {
        Buffer<LagrangeNode<3>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
        for (std::size_t e = 0; e < nodes.size(); ++e)
            if (kinds[e] != EdgeKind::volume)
                nodes[e].point = norm(mesh.linear.points[mesh.edges.vertices[e][0]]) * normalised(nodes[e].point);
        return nodes;
    }
};

}  // namespace camber::testing
