module;
#include <cstddef>
#include <cstdint>
export module camber.cad:vertex_moves;
import camber.core;
import camber.surface;
import :association;
import :model;

export namespace camber {

/// What is done about vertices of the boundary that are off the model.
enum class CadVertices : std::uint8_t { keep, move };
[[nodiscard]] constexpr auto words(CadVertices) {
    return words_of(Word{CadVertices::keep, "keep"}, Word{CadVertices::move, "move"});
}

/// Vertices where they are brought onto the model.
template <int D>
struct VerticesOnModel {
    Column<Vec<D>> points;   ///< of all vertices
    std::size_t moved = 0;   ///< that are elsewhere than they were
    std::size_t held = 0;    ///< of those that were off: short of their places, which an element does not allow
    double largest = 0;      ///< of the moves
    VertexId farthest = {};  ///< that made it
};

/// Moves vertices of facets on the model, each to the nearest point of what it lies on: of the model's vertex where
/// three faces (in 2D two curves) meet, of its edge where two do, else of the virtual face; at the end of the part that
/// is on the model of that face's rim, or, beside a surface that `geometry` (the model with those) prescribes, of the
/// curve of both. No element keeps less than a fifth of its volume, no facet less than a fifth of its area seen along
/// its normal: where one would, its vertices go half of the way, six times, and then not at all. Required vertices
/// stay. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<VerticesOnModel<D>> vertices_onto(const CadModel& model, const CadAssociation& association,
                                                        const LinearMesh<D>& mesh, const Geometry<D>& geometry,
                                                        const Execution& execution);

/// Checks that the mesh belongs to the model. Errors (input): too many of its vertices are off a face or an edge
/// (CadAssociation::misfit); the farthest is named, with its distance, the number of vertices that are off, and how to
/// move them onto the model, unless `vertices` says that they were moved.
template <int D>
[[nodiscard]] Outcome<Done> check_vertices(const CadAssociation& association, CadVertices vertices);

}  // namespace camber
