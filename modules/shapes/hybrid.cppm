// Small meshes with elements of several shapes.
module;
#include <array>
#include <cstddef>
export module camber.shapes:hybrid;
import camber.core;
import :box;

export namespace camber {

/// Unit square of quadrilaterals, of which every third one is cut into two triangles. The meshes of this file have the
/// facet references of `BoxOptions`, except surfaces and shells. Errors of this function and the next three: usage (no
/// cells, more than 1e8 vertices).
[[nodiscard]] Outcome<Mesh<2>> generate_plate(const std::array<int, 2>& cells);

/// Returns the plate as a standalone surface mesh at z = 0. All facets have reference 1.
[[nodiscard]] Outcome<Mesh<3>> generate_plate_in_space(const std::array<int, 2>& cells);

/// Unit cube of hexahedra.
[[nodiscard]] Outcome<Mesh<3>> generate_hexahedra(const std::array<int, 3>& cells);

/// Unit cube with hexahedra in the lower half and tetrahedra above. Pyramids in the lowest layer of tetrahedra lie on
/// the hexahedra. Further errors: usage (fewer than three cells along z).
[[nodiscard]] Outcome<Mesh<3>> generate_pyramids(const std::array<int, 3>& cells);

/// Shell with layers of prisms on the inner sphere (`inner_layer`) and tetrahedra above. Layer heights are measured
/// along rays from the centre. All references are 1, and there are no interface facets. Errors: those of `generate`,
/// usage (no layers).
[[nodiscard]] Outcome<Mesh<3>> generate_prisms(const ShellOptions<3>& options, const Execution& execution = {});

/// Bends a mesh smoothly. The move of a coordinate is `share` times the mesh size times products of sines and cosines
/// of the other coordinates. Elements of the meshes above stay valid up to `share` 0.05.
template <int D>
[[nodiscard]] Mesh<D> bend(Mesh<D> mesh, double share);

}  // namespace camber
