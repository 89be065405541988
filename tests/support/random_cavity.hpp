// Random cavities, for which an operation may or may not be possible.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "dice.hpp"

import camber.core;
import camber.cavity;

namespace camber::testing {

template <int D>
class RandomCavity {
  public:
    RandomCavity(const DynamicMesh<D>& mesh, Dice& dice) : mesh_(mesh), dice_(dice) {}

    /// Adds elements across faces of previous ones: few, many, or a ball and some neighbours.
    void grow(ElementId first, Cavity<D>& out) {
        out.elements = {first};
        const std::size_t how = dice_.below(3);
        if (how == 2) ball(mesh_, mesh_.elements.vertices[first][dice_.below(D + 1)], out.elements);
        for (std::size_t n = how == 1 ? 1 + dice_.below(20) : dice_.below(4); n > 0; --n) {
            const ElementId from = out.elements[dice_.below(out.elements.size())];
            const ElementId next = element_across(mesh_, from, static_cast<int>(dice_.below(D + 1)));
            if (next.valid() && std::ranges::find(out.elements, next) == out.elements.end())
                out.elements.push_back(next);
        }
        dice_.below(2) == 0 ? take_surfaces(out) : take_any(out);
        const auto once = [](auto& ids) {
            std::ranges::sort(ids);
            ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
        };
        once(out.facets);
        once(out.lines);
    }

  private:
    /// Adds some facets and lines of the elements.
    void take_any(Cavity<D>& out) {
        for (const ElementId e : out.elements) {
            for (int i = 0; i <= D; ++i)
                if (const FacetId f = facet_at(mesh_, e, i); f.valid() && dice_.below(2) == 0) out.facets.push_back(f);
            for (const EdgeId edge : mesh_.edges_of[e])
                if (const LineId l = mesh_.line_at(edge); l.valid() && dice_.below(3) == 0) out.lines.push_back(l);
        }
    }
    /// Adds the facets inside the cavity, those on its boundary for some references, and the lines between them.
    void take_surfaces(Cavity<D>& out) {
        const auto is_taken = [&](ElementId e) { return std::ranges::find(out.elements, e) != out.elements.end(); };
        const std::uint64_t references = dice_.below(1U << 16U);
        const std::size_t ends = dice_.below(2);
        for (const ElementId e : out.elements)
            for (int i = 0; i <= D; ++i) {
                const FacetId f = facet_at(mesh_, e, i);
                if (!f.valid()) continue;
                const ElementId other = element_across(mesh_, e, i);
                const auto bit = static_cast<unsigned>(mesh_.facets.references[f]) % 16U;
                if (other.valid() ? is_taken(other) : (references >> bit & 1U) != 0) out.facets.push_back(f);
            }
        if constexpr (D == 3)
            for (const ElementId e : out.elements)
                for (const EdgeId edge : mesh_.edges_of[e]) {
                    const LineId line = mesh_.line_at(edge);
                    if (!line.valid()) continue;
                    const auto has_both = [&](FacetId f) {
                        return std::ranges::all_of(mesh_.edges[edge], [&](VertexId v) {
                            return local_vertex(mesh_.facets.vertices[f], v) >= 0;
                        });
                    };
                    if (std::ranges::count_if(out.facets, has_both) > static_cast<std::ptrdiff_t>(ends))
                        out.lines.push_back(line);
                }
    }

    const DynamicMesh<D>& mesh_;
    Dice& dice_;
};

}  // namespace camber::testing
