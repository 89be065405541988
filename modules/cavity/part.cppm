module;
#include <cstddef>
#include <cstdint>
export module camber.cavity:part;
import camber.core;
import :mesh;

export namespace camber {

/// Some elements of a mesh that changes, with what is on them: the whole mesh, or what a cut along faces leaves.
template <int D>
struct MeshPart {
    LinearMesh<D> mesh;          ///< feature edges: its lines, each once; neither directions nor groups
    Column<VertexState> states;  ///< one a vertex, as in the whole
    Column<Marks> facet_marks;   ///< frozen: of facets between this part and another
    Column<Marks> line_marks;    ///< one a feature edge
};

/// A part, ready to be changed.
template <int D>
struct DynamicPart {
    DynamicMesh<D> mesh;
    Column<std::uint8_t> on_rim;  ///< of each vertex: whether it is on the cut, and so of other parts too
};

/// The part as a mesh that changes while its rim stays: vertices there are required, those of surfaces corners for the
/// time being, as are frozen facets and lines of the rim. Where a surface goes on beyond the rim a line is added behind
/// those that are given: of surfaces there are then no ends. Vertices where the walk from face to face does not find
/// all of the part are frozen. Errors: two facets or more than two elements on a face (input); rows that do not fit
/// (internal); stopped, memory.
template <int D>
[[nodiscard]] Outcome<DynamicPart<D>> make_dynamic_part(const MeshPart<D>& part, const Execution& execution);

}  // namespace camber
