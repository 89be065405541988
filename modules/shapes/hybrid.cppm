// Small meshes with elements of several shapes.
module;
#include <array>
#include <cstddef>
export module camber.shapes:hybrid;
import camber.core;
import :box;

export namespace camber {

/// Generates the unit square in quadrilaterals; every third one is cut into two triangles. Facet references: see
/// `BoxOptions`. Errors of this and the next three functions: usage (no cells, over 1e8 vertices).
[[nodiscard]] Outcome<Mesh<2>> generate_plate(const std::array<int, 2>& cells);

/// Same, as a standalone surface mesh at z = 0 with facet reference 1.
[[nodiscard]] Outcome<Mesh<3>> generate_plate_in_space(const std::array<int, 2>& cells);

/// Generates the unit cube in hexahedra. Facet references: see `BoxOptions`.
[[nodiscard]] Outcome<Mesh<3>> generate_hexahedra(const std::array<int, 3>& cells);

/// Generates the unit cube: hexahedra in the lower half, above them a layer of pyramids and tetrahedra, then tetrahedra
/// only. The pyramids stand on hexahedra. Facet references: see `BoxOptions`. Errors also: usage (fewer than three
/// cells along z).
[[nodiscard]] Outcome<Mesh<3>> generate_pyramids(const std::array<int, 3>& cells);

/// Generates a shell with layers of prisms on the inner sphere (`inner_layer`, heights along rays) and tetrahedra above
/// them. All materials are 1, and the layers have no interface facets. Errors: those of `generate`, usage (no layers).
[[nodiscard]] Outcome<Mesh<3>> generate_prisms(const ShellOptions<3>& options, const Execution& execution = {});

/// Warps a mesh smoothly: each coordinate is moved by `share` times the mesh size times products of sines and cosines
/// of the other coordinates. Elements of the meshes above stay valid for shares up to 0.05.
template <int D>
[[nodiscard]] Mesh<D> bend(Mesh<D> mesh, double share);

}  // namespace camber
