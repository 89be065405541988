module;
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.distributed:sent_parts;
import camber.core;
import camber.ordering;
import :adaptation_rows;

namespace camber {

using PartNumber = std::uint32_t;

/// A simplex on its way into a part.
template <int K>
struct SentSimplex {
    std::uint64_t number = 0;  ///< in the order of the whole
    PartNumber part = 0;
    AdaptedSimplex<K> simplex;
};

/// What goes from a rank to another when a mesh is cut: simplices by rows of `vertices`, those of `by_number` by the
/// numbers of their vertices, which go along with the elements of others. The latter may be of the part or not.
template <int D>
struct SentRows {
    Buffer<AdaptedVertex<D>> vertices;
    Buffer<SentSimplex<D>> elements;
    Buffer<SentSimplex<D - 1>> facets;
    Buffer<SentSimplex<1>> lines;
    Buffer<SentSimplex<D - 1>> facets_by_number;
    Buffer<SentSimplex<1>> lines_by_number;

    /// f(rows) of each kind.
    static void each_kind(auto& all, auto&& f) {
        f(all.vertices), f(all.elements), f(all.facets), f(all.lines);
        f(all.facets_by_number), f(all.lines_by_number);
    }
};

/// Parts [first, last) made of what all ranks sent: vertices follow the curve in `grid`, elements that of their first
/// vertices, facets and lines the whole. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<std::vector<AdaptationRows<D>>> parts_of_sent(std::vector<SentRows<D>> sent,
                                                                    const PointBox<D>& grid, PartNumber first,
                                                                    PartNumber last, const Execution& execution);

/// The elements around each vertex. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> elements_around(const AdaptationRows<D>& rows, const Execution& execution);

}  // namespace camber
