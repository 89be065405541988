module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.distributed:whole_surface;
import camber.core;
import camber.recipes;
import :ringed_parts;
import :curve_blocks;
import :rows;

export namespace camber {

/// The boundary of a mesh in blocks, which each rank has as a whole: features, patches and the surfaces through it are
/// not found by looking around, and it is small beside what it encloses. A mesh without elements, in the order of the
/// whole one.
template <int D>
struct WholeSurface {
    QuadraticMesh<D> mesh;               ///< facets and feature edges, with the nodes of `elevate`
    std::vector<GlobalNumber> vertices;  ///< of each of its own, rising
    Boundary<D> boundary;
    CurveInput<D> input;  ///< of its edges, see curve_input

    /// Of some vertices, rising, which of its own each is; an invalid id: none.
    [[nodiscard]] std::vector<VertexId> places_of(std::span<const GlobalNumber> numbers) const;
    /// The edge between two vertices, or an invalid id.
    [[nodiscard]] EdgeId find(GlobalNumber a, GlobalNumber b) const;
};

/// From the rows. Errors: those of the rows, of find_boundary and curve_input; required elements on the boundary, which
/// are not known here (unsupported).
template <int D>
[[nodiscard]] Outcome<WholeSurface<D>> whole_surface(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                                     const Execution& execution);

}  // namespace camber
