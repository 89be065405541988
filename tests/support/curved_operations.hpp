// Requests of quadratic operations at random places of a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bowed.hpp"
#include "dice.hpp"
#include "insertion.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.adapt;

namespace camber::testing {

/// The kinds of `kinds` without cavities of arbitrary shape, and splits: insertions on an edge that use its curve.
struct CurvedKind {
    Kind kind;
    std::size_t share = 1;  ///< relative frequency: higher where fewer attempts are accepted
    bool splits = false;
};
template <int D>
constexpr auto curved_kinds() {
    using enum Operation;
    using enum VertexPlace;
    if constexpr (D == 2)
        return std::array<CurvedKind, 11>{{{{insert, inside}, 1, true},
                                           {{insert, surface}, 1, true},
                                           {{insert, inside}},
                                           {{collapse, inside}, 2},
                                           {{collapse, surface}, 2},
                                           {{swap_edge, inside}, 2},
                                           {{reinsert, inside}},
                                           {{reinsert, surface}},
                                           {{reinsert, corner}},
                                           {{move, inside}},
                                           {{move, surface}}}};
    else
        return std::array<CurvedKind, 18>{{{{insert, inside}, 1, true},
                                           {{insert, surface}, 1, true},
                                           {{insert, line}, 1, true},
                                           {{insert, inside}},
                                           {{insert, surface}},
                                           {{collapse, inside}, 3},
                                           {{collapse, surface}, 3},
                                           {{collapse, line}, 3},
                                           {{swap_edge, inside}, 6},
                                           {{swap_edge, surface}, 4},
                                           {{swap_face, inside}, 20},
                                           {{reinsert, inside}},
                                           {{reinsert, surface}},
                                           {{reinsert, line}},
                                           {{reinsert, corner}},
                                           {{move, inside}},
                                           {{move, surface}},
                                           {{move, line}}}};
}

/// Returns a random kind according to the shares.
template <int D>
std::size_t any_kind(Dice& dice) {
    constexpr auto all = curved_kinds<D>();
    std::size_t shares = 0;
    for (const CurvedKind& kind : all) shares += kind.share;
    std::size_t left = dice.below(shares);
    std::size_t k = 0;
    for (; left >= all[k].share; ++k) left -= all[k].share;
    return k;
}

/// The curve of a split edge and the parameter of the new point on it.
template <int D>
struct MeantSplit {
    QuadraticEdge<D> curve;
    std::array<VertexId, 2> ends;
    double t = 0;
};
template <int D>
struct CurvedTry {
    CavityRequest<D> request;
    std::optional<MeantSplit<D>> split;
};

/// Chooses random places for operations and builds their requests.
template <int D>
class CurvedTrying {
  public:
    CurvedTrying(const BowedDomain<D>& domain, Dice& dice) : domain_(domain), r_(domain.state), dice_(dice) {}

    /// Returns nothing if no place of the kind is found.
    [[nodiscard]] std::optional<CurvedTry<D>> any(const CurvedKind& kind) {
        if (kind.kind.operation == Operation::insert) {
            const bool is_anywhere = !kind.splits && kind.kind.place == VertexPlace::inside && dice_.below(2) == 0;
            return is_anywhere ? anywhere() : on_simplex(kind);
        }
        Patch<D> patch;
        StarWorkspace<D> workspace;
        if (!Trying<D>(r_.mesh, dice_, workspace).choose(kind.kind, patch)) return {};
        CurvedTry<D> out;
        out.request.cavity = std::move(patch.removed);
        out.request.join_to(r_, patch.point.vertex);
        if (patch.point.place) {
            out.request.place = kind.kind.place == VertexPlace::inside
                                    ? out.request.place + stretched(0.2 * dice_.vector<D>(), domain_.stretch)
                                    : *patch.point.place;
            fill_request(out.request);
        }
        return out;
    }

  private:
    [[nodiscard]] ElementId any_element() {
        for (;;)
            if (const ElementId e(dice_.below(r_.mesh.elements.size())); !r_.mesh.is_free(e)) return e;
    }
    void fill_request(CavityRequest<D>& request) const {
        const FieldSample<D> sample = sample_with_recovered_gradient(domain_.goal.field, request.place, ElementId{});
        request.metric = VertexMetric<D>(sample.log_metric, sample.location.element);
        request.gradient = sample.gradient;
    }

    /// A point at a random place, independent of curves; its cavity is that of the straight elements that contain it.
    [[nodiscard]] std::optional<CurvedTry<D>> anywhere() {
        CurvedTry<D> out;
        const auto& vertices = r_.mesh.elements.vertices[any_element()];
        const auto xi = dice_.barycentric<D>();
        for (int i = 0; i <= D; ++i) out.request.place += xi[i] * r_.mesh.points[vertices[i]];
        auto in = insertion(r_.mesh, out.request.place);
        if (!in || in->is_at_vertex() || in->place != VertexPlace::inside) return {};
        out.request.cavity = std::move(in->cavity);
        out.request.fixed_element_count = out.request.cavity.elements.size();
        fill_request(out.request);
        return out;
    }
    /// A point within a curved simplex of up to D dimensions that lies on the requested place; for splits within an
    /// edge.
    [[nodiscard]] std::optional<CurvedTry<D>> on_simplex(const CurvedKind& kind) {
        for (int tries = 0; tries < 60; ++tries) {
            PointSite<D> site{any_element(), {}};
            for (std::size_t left = kind.splits ? 2 : 3 + dice_.below(D - 1); left > 0;) {
                bool& spans = site.spans[dice_.below(D + 1)];
                left -= spans ? 0 : 1;
                spans = true;
            }
            Insertion<D> in = insertion_at(r_.mesh, site);
            if (in.place != kind.kind.place) continue;
            CurvedTry<D> out;
            out.request.cavity = std::move(in.cavity);
            out.request.fixed_element_count = out.request.cavity.elements.size();
            put_point(site, out);
            fill_request(out.request);
            return out;
        }
        return {};
    }
    /// Computes the point relative to the first vertex, so that it lies on axis-parallel planes without rounding.
    void put_point(const PointSite<D>& site, CurvedTry<D>& out) {
        const auto& vertices = r_.mesh.elements.vertices[site.element];
        std::vector<int> spanned;
        for (int i = 0; i <= D; ++i)
            if (site.spans[i]) spanned.push_back(i);
        std::array<double, D + 1> xi{};
        double sum = 0;
        for (const int i : spanned) sum += xi[i] = dice_.uniform(0.4, 1);
        for (double& x : xi) x /= sum;
        const auto point = [&](int i) { return r_.mesh.points[vertices[i]]; };
        Vec<D> origin = point(spanned[0]);
        for (const int i : spanned) origin += xi[i] * (point(i) - point(spanned[0]));
        out.request.origin = out.request.place = origin;
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [i, j] = local_edges<D>[k];
            const Vec<D> offset = r_.mesh.nodes[r_.mesh.edges_of[site.element][k]].point - midpoint(point(i), point(j));
            out.request.place += 4 * xi[i] * xi[j] * offset;
        }
        if (spanned.size() != 2) return;
        const auto [i, j] = std::array{spanned[0], spanned[1]};
        const EdgeId edge = r_.mesh.edges_of[site.element][edge_between<D>[i][j]];
        out.request.halves = {vertices[i], vertices[j]};
        out.split = MeantSplit<D>{{point(i), r_.mesh.nodes[edge], point(j)}, out.request.halves, xi[j]};
    }

    const BowedDomain<D>& domain_;
    const Adaptation<D>& r_;
    Dice& dice_;
};

}  // namespace camber::testing
