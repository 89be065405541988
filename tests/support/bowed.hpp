// Quadratic meshes with bowed edges, stretched along the axes together with their metric.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "domains.hpp"
#include "meshes.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.validity;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// Minimum distance of the node of a bowed edge from its chord, as a share of the chord, before stretching.
inline constexpr double min_bow = 0.05;

/// Scales p componentwise.
template <int D>
Vec<D> stretched(Vec<D> p, const Vec<D>& stretch) {
    for (int i = 0; i < D; ++i) p[i] *= stretch[i];
    return p;
}
template <int D>
Vec<D> unstretched(Vec<D> p, const Vec<D>& stretch) {
    for (int i = 0; i < D; ++i) p[i] /= stretch[i];
    return p;
}
template <int D>
double bow_of(const DynamicMesh<D>& mesh, EdgeId e, const Vec<D>& stretch) {
    const auto& [a, b] = mesh.edges[e];
    const Vec<D> chord = unstretched(mesh.points[b] - mesh.points[a], stretch);
    const Vec<D> offset = unstretched(mesh.nodes[e].point - midpoint(mesh.points[a], mesh.points[b]), stretch);
    return norm(offset - (dot(offset, chord) / norm_squared(chord)) * chord) / norm(chord);
}

/// The elements at each edge, and the axes along which its node may move: within the planes of its facets, and along
/// its own line.
template <int D>
struct BowingPlaces {
    std::vector<std::vector<ElementId>> shells;
    std::vector<std::array<bool, D>> free;

    BowingPlaces(const DynamicMesh<D>& mesh, const Vec<D>& stretch) : shells(mesh.edges.size()) {
        std::array<bool, D> all;
        all.fill(true);
        free.assign(mesh.edges.size(), all);
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
            if (mesh.is_free(ElementId(e))) continue;
            const auto& vertices = mesh.elements.vertices[e];
            for (int k = 0; k < edges_per_simplex<D>; ++k) {
                const EdgeId edge = mesh.edges_of[e][k];
                shells[edge.index()].push_back(ElementId(e));
                for (int face = 0; face <= D; ++face)
                    if (face != local_edges<D>[k][0] && face != local_edges<D>[k][1])
                        if (const FacetId f = facet_at(mesh, ElementId(e), face); f.valid())
                            free[edge.index()][plane_of(mesh, mesh.facets.vertices[f], stretch)] = false;
                if (!mesh.line_at(edge).valid()) continue;
                const auto [i, j] = local_edges<D>[k];
                const Vec<D> along = unstretched(mesh.points[vertices[j]] - mesh.points[vertices[i]], stretch);
                for (int c = 0; c < D; ++c) free[edge.index()][c] = std::abs(along[c]) > 0.5 * norm(along);
            }
        }
    }

  private:
    /// Returns the axis normal to a facet: the one of minimum extent.
    static int plane_of(const DynamicMesh<D>& mesh, const SimplexVertices<D - 1>& facet, const Vec<D>& stretch) {
        Vec<D> extent;
        for (const VertexId v : facet) {
            const Vec<D> side = unstretched(mesh.points[v] - mesh.points[facet[0]], stretch);
            for (int c = 0; c < D; ++c) extent[c] = std::max(extent[c], std::abs(side[c]));
        }
        int least = 0;
        for (int c = 1; c < D; ++c)
            if (extent[c] < extent[least]) least = c;
        return least;
    }
};

/// Replaces the nodes of most edges by bowed ones where elements stay valid; boundary nodes stay within their planes
/// and lines.
template <int D>
void bow(Adaptation<D>& r, const Vec<D>& stretch, Dice& dice) {
    const BowingPlaces<D> places(r.mesh, stretch);
    Buffer<LagrangeNode<D>> nodes(r.mesh.nodes.begin(), r.mesh.nodes.end());
    const auto is_valid = [&](ElementId e) {
        NodalSimplex<D> element{nodes_of(r.mesh, e)};
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            element.nodes[D + 1 + k] = nodes[r.mesh.edges_of[e][k].index()].point;
        return decide(element, 0.15) == Verdict::valid;
    };
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        if (r.mesh.is_free(EdgeId(e)) || dice.below(4) == 0) continue;
        const auto& [a, b] = r.mesh.edges[e];
        const LagrangeNode<D> before = nodes[e];
        Vec<D> direction = dice.vector<D>();
        for (int c = 0; c < D; ++c)
            if (!places.free[e][c]) direction[c] = 0;
        if (!(norm(direction) > 0)) continue;
        direction = (norm(unstretched(r.mesh.points[b] - r.mesh.points[a], stretch)) / norm(direction)) * direction;
        for (double share = dice.uniform(1.1, 3) * min_bow; share > min_bow; share /= 1.5) {
            nodes[e].point = midpoint(r.mesh.points[a], r.mesh.points[b]) + stretched(share * direction, stretch);
            if (std::ranges::all_of(places.shells[e], is_valid)) break;
            nodes[e] = before;
        }
    }
    r.mesh.nodes = std::move(nodes);
    r.mesh.stamp = new_stamp();
    must(measure_lengths(r, one_thread));
}

/// A mesh stretched along the axes by up to 10^6, and a metric that fits it. Before stretching, sizes are 1 and grow
/// linearly along the first axis.
template <int D>
struct BowedDomain {
    Vec<D> stretch;
    AdaptationGoal<D> goal;
    Adaptation<D> state;
};
template <int D>
Vec<D> random_stretch(Dice& dice) {
    Vec<D> stretch;
    for (double& s : stretch.c) s = std::pow(10.0, dice.uniform(-6, 0));
    stretch[static_cast<int>(dice.below(D))] = 1;
    return stretch;
}
template <int D>
BowedDomain<D> bowed_domain(LinearMesh<D> mesh, Dice& dice) {
    const Vec<D> stretch = random_stretch<D>(dice);
    const double growth = dice.uniform(0, 0.3);
    Buffer<LogMetric<D>> logs(mesh.points.size());
    Buffer<Vec<D>> points(mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) {
        points[v] = stretched(mesh.points[v], stretch);
        logs[v] = log_metric_of_sizes<D>((1 + growth * mesh.points[v][0]) * stretch);
    }
    mesh.points = std::move(points);
    BowedDomain<D> out{
        stretch,
        {must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<D>>(std::move(logs)), one_thread)),
         {}},
        {}};
    out.state = must(begin_adaptation(must(elevate(mesh, one_thread)), {}, out.goal, one_thread));
    bow(out.state, stretch, dice);
    return out;
}

}  // namespace camber::testing
