module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.run:page_mesh;
import camber.core;
import camber.bezier;
import camber.drawing;

/// What of a mesh goes into a page.
namespace camber::run {

/// Places of a cut along an axis: after step s, the mesh's box being cut into `cut_steps` + 1 equal slices. An element
/// is kept where its key, the step before which its centroid lies, is no later.
inline constexpr int cut_steps = 255;

/// An inner face is seen where the cut keeps one of its elements.
struct InnerFace {
    std::array<NodeNumber, 6> nodes{};
    std::uint32_t element = 0, other = 0;
};

/// Keys of all elements along each axis; 0 of axes that there are not. Of a surface alone, of its facets. Errors:
/// stopped, memory.
using CutKeys = std::array<std::uint8_t, 3>;
template <int D>
[[nodiscard]] Outcome<Column<CutKeys>> cut_keys(const LinearMesh<D>& mesh, const Box<D>& box,
                                                const Execution& execution);

/// Inner faces of tetrahedra, and the steps at which all that a cut uncovers are among them.
struct InnerFaces {
    std::vector<InnerFace> faces;
    std::array<std::vector<int>, 3> steps;  ///< along each axis, rising
    std::size_t all = 0;                    ///< that the mesh has
};
/// Every step of the cut, along each axis.
[[nodiscard]] std::array<std::vector<int>, 3> every_step();
/// All of them, where they are no more than `budget`; else those of as many places as have room, the middles first,
/// then the quarters, and so on. Errors: stopped, memory.
[[nodiscard]] Outcome<InnerFaces> inner_faces(const QuadraticMesh<3>& mesh, const Column<CutKeys>& keys,
                                              std::size_t budget, const Execution& execution);

/// The faces of one element (of a 2D mesh or a surface: itself).
template <int D>
[[nodiscard]] std::vector<std::array<NodeNumber, 6>> faces_of_element(const QuadraticMesh<D>& mesh, std::size_t e);

/// The faces in an order in which those near each other in space follow each other mostly: along a Morton curve
/// through the centroids. Packed, their numbers are smaller so.
template <int D>
[[nodiscard]] std::vector<Face> along_curve(const QuadraticMesh<D>& mesh, const Column<Face>& faces, const Box<D>& box);

}  // namespace camber::run
