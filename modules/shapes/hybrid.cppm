// Small meshes with elements of several shapes.
module;
#include <array>
#include <cstddef>
export module camber.shapes:hybrid;
import camber.core;
import :box;

export namespace camber {

/// The unit square in cells × cells quadrilaterals, of which every third is cut into two triangles. Facet references
/// as those of `BoxOptions`. Errors: usage (no cells), stopped.
[[nodiscard]] Outcome<Mesh<2>> generate_plate(const std::array<int, 2>& cells, const Execution& execution = {});

/// The same in space, over z = 0: a surface alone, without elements; facets of reference 1.
[[nodiscard]] Outcome<Mesh<3>> generate_plate_in_space(const std::array<int, 2>& cells,
                                                       const Execution& execution = {});

/// The unit cube in hexahedra. Facet references as those of `BoxOptions`. Errors: usage (no cells), stopped.
[[nodiscard]] Outcome<Mesh<3>> generate_hexahedra(const std::array<int, 3>& cells, const Execution& execution = {});

/// The unit square times 0 < z < 1 + height: hexahedra to z = 1, then a layer of cubes whose lower sides are bases of
/// pyramids and which are tetrahedra otherwise, up to cubes of tetrahedra alone. Facet references as those of
/// `BoxOptions`. Errors: usage (no cells, fewer than three of them along z), stopped.
[[nodiscard]] Outcome<Mesh<3>> generate_pyramids(const std::array<int, 3>& cells, const Execution& execution = {});

/// Prisms on tetrahedra: the shell of the options, whose tetrahedra begin above layers of prisms on the inner sphere.
/// The layers are those of `inner_layer`, whose heights are along rays; its `material` and `interface` are ignored.
/// Errors: those of `generate`, usage (no layers).
[[nodiscard]] Outcome<Mesh<3>> generate_prisms(const ShellOptions<3>& options, const Execution& execution = {});

/// The mesh bent by a smooth map: each coordinate moves by `share` times the size of the mesh times products of sines
/// and cosines of the others. Up to a share of 0.05 elements of the meshes above stay valid.
template <int D>
[[nodiscard]] Mesh<D> bent(Mesh<D> mesh, double share);

}  // namespace camber
