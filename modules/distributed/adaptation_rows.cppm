module;
#include <cstddef>
#include <cstdint>
export module camber.distributed:adaptation_rows;
import camber.core;
import camber.metric;
import camber.surface;
import camber.cavity;
import camber.operation;

/// A mesh that is brought to a metric as plain rows, the whole or a part: what is cut, moved between ranks and joined.
export namespace camber {

/// All that is known of a vertex. `number` is its own in the whole: none of one that is new, or is this part's alone
/// (but for frozen ones, on which there may be something that is of no part).
template <int D>
struct AdaptedVertex {
    VertexId number;
    VertexId origin;  ///< of one that directions or associations are given at: its number when all began
    Vec<D> point;
    Reference reference = 0;
    VertexState state;
    bool is_off_geometry = false;
    VertexMetric<D> metric;
    GeometryPlace place;
};

/// A K-simplex by rows of vertices.
template <int K>
struct AdaptedSimplex {
    SimplexVertices<K> vertices;
    Reference reference = 0, entity = 0;
    Marks marks;
    std::uint8_t sides = 0;  ///< of a facet: on how many of its sides there are elements, in the whole
};

/// Facets between two parts are in both, marked frozen; lines (3D) in each part that has an element there; vertices
/// likewise.
template <int D>
struct AdaptationRows {
    Buffer<AdaptedVertex<D>> vertices;
    Buffer<AdaptedSimplex<D>> elements;
    Buffer<AdaptedSimplex<D - 1>> facets;
    Buffer<AdaptedSimplex<1>> lines;

    /// f(rows) of each kind.
    static void each_kind(auto& all, auto&& f) { f(all.vertices), f(all.elements), f(all.facets), f(all.lines); }
};

/// The rows of a whole mesh of degree 1, in its order; vertices are numbered by it. Errors: memory.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> rows_of(const Adaptation<D>& whole);

/// A part between cutting and joining.
template <int D>
struct AdaptedPart {
    Adaptation<D> state;
    Column<std::uint8_t> on_rim;  ///< of each vertex that the rows had
    std::size_t rim_lines = 0;    ///< behind those of the rows, for the time being
};

/// The rows as a mesh to change, of which the rim stays (see make_dynamic_part). Errors: those of make_dynamic_part.
template <int D>
[[nodiscard]] Outcome<AdaptedPart<D>> assembled(const AdaptationRows<D>& rows, const Execution& execution);

/// The rows of a part that was changed; `before`: those that it was made of, as which its rim is still. Errors: memory.
template <int D>
[[nodiscard]] Outcome<AdaptationRows<D>> rows_of_part(const AdaptedPart<D>& part, const AdaptationRows<D>& before);

}  // namespace camber
