// Operations at random places of a mesh, as patches or with the reason of their rejection.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "filling.hpp"
#include "insertion.hpp"
#include "meshes.hpp"
#include "random_cavity.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

enum class Operation : std::uint8_t { insert, collapse, swap_edge, swap_face, reinsert, move, any_cavity };

/// An operation and the place of its point, removed vertex or edge.
struct Kind {
    Operation operation;
    VertexPlace place;
};
template <int D>
constexpr auto kinds() {
    using enum Operation;
    using enum VertexPlace;
    if constexpr (D == 2)
        return std::array<Kind, 11>{{{insert, inside},
                                     {insert, surface},
                                     {collapse, inside},
                                     {collapse, surface},
                                     {swap_edge, inside},
                                     {reinsert, inside},
                                     {reinsert, surface},
                                     {reinsert, corner},
                                     {move, inside},
                                     {move, surface},
                                     {any_cavity, inside}}};
    else
        return std::array<Kind, 18>{{{insert, inside},
                                     {insert, surface},
                                     {insert, line},
                                     {collapse, inside},
                                     {collapse, surface},
                                     {collapse, line},
                                     {swap_edge, inside},
                                     {swap_edge, surface},
                                     {swap_face, inside},
                                     {reinsert, inside},
                                     {reinsert, surface},
                                     {reinsert, line},
                                     {reinsert, corner},
                                     {move, inside},
                                     {move, surface},
                                     {move, line},
                                     {any_cavity, inside},
                                     {any_cavity, surface}}};
}

/// Result of an attempt: the failures of `star` in the same order, then those of the tests.
enum class Refusal : std::uint8_t {
    none,
    empty,
    required,
    surface,
    line,
    ball,
    exists,
    place,   ///< no place of the kind was found
    volume,  ///< an element would be inverted or the cavity not filled
};
inline constexpr std::size_t refusals = 9;

template <int D>
struct Attempt {
    std::optional<Patch<D>> patch;  ///< empty if the attempt was rejected
    Refusal refused = Refusal::none;
};

/// Chooses random places, cavities and points of operations.
template <int D>
class Trying {
  public:
    Trying(const DynamicMesh<D>& mesh, Dice& dice, StarWorkspace<D>& workspace)
        : mesh_(mesh), dice_(dice), w_(workspace) {}

    /// Builds the star by topology only, independent of vertex positions.
    [[nodiscard]] Attempt<D> starred(Kind kind) {
        Patch<D> patch{mesh_.stamp, {}, {}, {}};
        if (!choose(kind, patch)) return {{}, Refusal::place};
        const StarFailure failure = star(mesh_, patch.removed, patch.point.vertex, w_, patch.star);
        if (failure != StarFailure::none) return {{}, static_cast<Refusal>(failure)};
        return {std::move(patch), Refusal::none};
    }
    /// Builds a star that fills its cavity with positive elements. An inserted point is located in the simplex it was
    /// put into.
    [[nodiscard]] Attempt<D> planned(Kind kind) {
        Attempt<D> attempt = starred(kind);
        if (kind.operation == Operation::insert) expect_found();
        if (attempt.patch && !fills(mesh_, *attempt.patch)) return {{}, Refusal::volume};
        return attempt;
    }
    /// Chooses the cavity and the point; returns false if no place of the kind is found.
    [[nodiscard]] bool choose(Kind kind, Patch<D>& patch) {
        switch (kind.operation) {
            case Operation::insert: return choose_insertion(kind.place, patch);
            case Operation::collapse: return choose_collapse(kind.place, patch);
            case Operation::swap_edge: return choose_edge_swap(kind.place, patch);
            case Operation::swap_face: return choose_face_swap(patch);
            case Operation::reinsert: return choose_vertex(kind.place, patch);
            case Operation::move: return choose_vertex(kind.place, patch) && choose_move(kind.place, patch);
            case Operation::any_cavity: break;
        }
        RandomCavity<D>(mesh_, dice_).grow(any_element(), patch.removed);
        const auto& v = mesh_.elements.vertices[patch.removed.elements[0]];
        if (kind.place == VertexPlace::inside)
            patch.point.place = inner_point(v);
        else
            patch.point.vertex = v[dice_.below(D + 1)];
        return true;
    }

  private:
    [[nodiscard]] ElementId any_element() {
        for (;;)
            if (const ElementId e(dice_.below(mesh_.elements.size())); !mesh_.is_free(e)) return e;
    }
    [[nodiscard]] Vec<D> inner_point(const auto& vertices) {
        Vec<D> sum;
        double all = 0;
        for (const VertexId v : vertices) {
            const double w = dice_.uniform(0.3, 1);
            sum += w * mesh_.points[v];
            all += w;
        }
        return sum / all;
    }

    /// Chooses a simplex of up to D dimensions on the requested place, and a point in its interior.
    [[nodiscard]] bool choose_insertion(VertexPlace place, Patch<D>& patch) {
        for (int tries = 0; tries < 40; ++tries) {
            PointSite<D> site{any_element(), {}};
            for (std::size_t left = 2 + dice_.below(D); left > 0;) {
                bool& spans = site.spans[dice_.below(D + 1)];
                left -= spans ? 0 : 1;
                spans = true;
            }
            Insertion<D> in = insertion_at(mesh_, site);
            if (in.place != place) continue;
            std::vector<VertexId> vertices;
            for (int i = 0; i <= D; ++i)
                if (site.spans[i]) vertices.push_back(mesh_.elements.vertices[site.element][i]);
            patch.removed = std::move(in.cavity);
            patch.point.place = inserted_ = inner_point(vertices);
            std::ranges::sort(vertices);
            spanned_ = std::move(vertices);
            return true;
        }
        spanned_.clear();
        return false;
    }
    void expect_found() {
        if (spanned_.empty()) return;
        // `fills` excludes flatter elements, and the point is near the middle of its simplex, so 1e-6 decides.
        const PointSite<D> site = locate(mesh_, inserted_, 1e-6).value();
        std::vector<VertexId> found;
        for (int i = 0; i <= D; ++i)
            if (site.spans[i]) found.push_back(mesh_.elements.vertices[site.element][i]);
        std::ranges::sort(found);
        if (found != spanned_) throw std::runtime_error("a point is found elsewhere than it was put");
    }

    [[nodiscard]] VertexId any_vertex(VertexPlace place) {
        for (int tries = 0; tries < 40; ++tries)
            if (const VertexId v = mesh_.elements.vertices[any_element()][dice_.below(D + 1)];
                mesh_.states[v].place == place)
                return v;
        return {};
    }
    [[nodiscard]] bool choose_vertex(VertexPlace place, Patch<D>& patch) {
        const VertexId v = any_vertex(place);
        if (!v.valid()) return false;
        cavity_of_vertex(mesh_, v, patch.removed);
        patch.point.vertex = v;
        return true;
    }
    [[nodiscard]] bool choose_collapse(VertexPlace place, Patch<D>& patch) {
        if (!choose_vertex(place, patch)) return false;
        const VertexId v = patch.point.vertex;
        std::vector<VertexId> ends;
        for (const ElementId e : patch.removed.elements)
            for (const VertexId w : mesh_.elements.vertices[e])
                if (w != v && may_collapse(mesh_, patch.removed, v, w)) ends.push_back(w);
        if (ends.empty()) return false;
        patch.point.vertex = ends[dice_.below(ends.size())];
        return true;
    }
    /// Moves along the surface or line of the vertex, which is flat.
    [[nodiscard]] bool choose_move(VertexPlace place, Patch<D>& patch) {
        const auto& [elements, facets, lines] = patch.removed;
        const Vec<D> from = mesh_.points[patch.point.vertex];
        if (mesh_.states[patch.point.vertex].marks.has(Mark::required)) return false;
        if (place == VertexPlace::inside) {
            patch.point.place = from + 0.2 * dice_.vector<D>();
            return true;
        }
        if (place == VertexPlace::surface ? facets.empty() : lines.empty()) return false;
        const Vec<D> to = place == VertexPlace::surface
                              ? inner_point(mesh_.facets.vertices[facets[dice_.below(facets.size())]])
                              : inner_point(mesh_.edges[mesh_.lines[lines[dice_.below(lines.size())]]]);
        patch.point.place = from + dice_.uniform(0, 0.5) * (to - from);
        return true;
    }

    [[nodiscard]] bool choose_edge_swap(VertexPlace place, Patch<D>& patch) {
        for (int tries = 0; tries < 40; ++tries) {
            const ElementId e = any_element();
            const int k = static_cast<int>(dice_.below(edges_per_simplex<D>));
            cavity_of_edge(mesh_, e, k, patch.removed);
            const auto& [elements, facets, lines] = patch.removed;
            if (!lines.empty() || facets.empty() != (place == VertexPlace::inside)) continue;
            std::vector<VertexId> ring;
            const auto add = [&](const auto& simplex) {
                for (const VertexId v : simplex)
                    if (local_vertex(mesh_.edges[mesh_.edges_of[e][k]], v) < 0) ring.push_back(v);
            };
            if (facets.empty())
                for (const ElementId s : elements) add(mesh_.elements.vertices[s]);
            else
                for (const FacetId f : facets) add(mesh_.facets.vertices[f]);
            if (ring.empty()) continue;
            patch.point.vertex = ring[dice_.below(ring.size())];
            return true;
        }
        return false;
    }
    [[nodiscard]] bool choose_face_swap(Patch<D>& patch) {
        const ElementId e = any_element();
        const int face = static_cast<int>(dice_.below(D + 1));
        cavity_of_face(mesh_, e, face, patch.removed);
        patch.point.vertex = mesh_.elements.vertices[e][face];
        return patch.removed.facets.empty();
    }

    const DynamicMesh<D>& mesh_;
    Dice& dice_;
    StarWorkspace<D>& w_;
    std::vector<VertexId> spanned_;  ///< vertices of the simplex that contains the last inserted point
    Vec<D> inserted_;
};

}  // namespace camber::testing
