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
struct VerticesOnModel {
    Column<Vec<3>> points;   ///< of all vertices
    std::size_t moved = 0;   ///< that are elsewhere than they were
    std::size_t held = 0;    ///< of those that were off: short of their places, which an element does not allow
    double largest = 0;      ///< of the moves
    VertexId farthest = {};  ///< that made it
};

/// Vertices of facets on the model, each at the nearest point of what it lies on: of the model's vertex where three
/// faces meet, of its edge where two do, else of the face; at the end of the part that is on the model of that face's
/// rim, or, beside a surface that `geometry` (the model with those) prescribes, of the curve of both. No element keeps
/// less than a fifth of its volume, no facet less than a fifth of its area seen along its normal: where one would, its
/// vertices go half of the way, six times, and then not at all. Required vertices stay. Errors: stopped.
[[nodiscard]] Outcome<VerticesOnModel> vertices_onto(const CadModel& model, const CadAssociation& association,
                                                     const LinearMesh<3>& mesh, const Geometry<3>& geometry,
                                                     const Execution& execution);

}  // namespace camber
