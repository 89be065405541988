// Small meshes with elements of several shapes.
module;
#include <array>
#include <cstddef>
export module camber.shapes:hybrid;
import camber.core;
import :box;

export namespace camber {

/// The unit square in cells × cells quadrilaterals, of which every third is cut into two triangles. Facet references
/// as those of `BoxOptions`. Errors: usage (no cells, more than 1e8 vertices); the same of the next three.
[[nodiscard]] Outcome<Mesh<2>> generate_plate(const std::array<int, 2>& cells);

/// The same in space, over z = 0: a surface alone, without elements; facets of reference 1.
[[nodiscard]] Outcome<Mesh<3>> generate_plate_in_space(const std::array<int, 2>& cells);

/// The unit cube in hexahedra. Facet references as those of `BoxOptions`.
[[nodiscard]] Outcome<Mesh<3>> generate_hexahedra(const std::array<int, 3>& cells);

/// The unit cube: hexahedra in the lower half, then a layer of cubes whose lower sides are bases of pyramids and which
/// are tetrahedra otherwise, then cubes of tetrahedra alone. Facet references as those of `BoxOptions`. Errors also:
/// usage (fewer than three cells along z).
[[nodiscard]] Outcome<Mesh<3>> generate_pyramids(const std::array<int, 3>& cells);

/// Prisms on tetrahedra: the shell of the options, whose tetrahedra begin above layers of prisms on the inner sphere.
/// The layers are those of `inner_layer`, whose heights are along rays. All elements have reference 1, and there are no
/// facets between materials.
/// Errors: those of `generate`, usage (no layers).
[[nodiscard]] Outcome<Mesh<3>> generate_prisms(const ShellOptions<3>& options, const Execution& execution = {});

/// Bends the mesh by a smooth map: each coordinate moves by `share` times the size of the mesh times products of sines
/// and cosines of the others. Up to a share of 0.05 elements of the meshes above stay valid.
template <int D>
[[nodiscard]] Mesh<D> bend(Mesh<D> mesh, double share);

}  // namespace camber
