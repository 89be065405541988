module;
#include <cstddef>
#include <span>
#include <vector>
module camber.operation:walls;
import camber.core;
import camber.crossing;
import camber.cavity;
import :state;

/// Walls of a mesh of degree 2 do not come to cross each other: positive Jacobians do not exclude it.
namespace camber {

/// The facets of a mesh by their boxes; nothing of a straight one.
template <int D>
[[nodiscard]] FacetGrid<D> walls_of(const DynamicMesh<D>& mesh);

/// What a commit changed of them.
template <int D>
void follow_walls(FacetGrid<D>& walls, const DynamicMesh<D>& mesh, const IdChanges<FacetId>& facets);

/// The facets that a patch would make.
template <int D>
[[nodiscard]] std::vector<NodalFacet<D>> new_facets(const DynamicMesh<D>& mesh, const Patch<D>& patch);

/// Whether what a patch removes and what it makes lies in one plane of coordinates, and no line goes. Valid elements
/// make facets that, in a plane, are positive too: each point of it is covered as often as the border winds around it.
/// That border stays, and so no facet comes where none was, nor covers another.
template <int D>
[[nodiscard]] bool keeps_its_plane(const DynamicMesh<D>& mesh, const Patch<D>& patch,
                                   std::span<const NodalFacet<D>> made);

/// Whether facets that a patch makes are proved not to cross themselves, and to be disjoint from each other and from
/// the mesh's other ones.
template <int D>
[[nodiscard]] bool are_walls_clear(const Adaptation<D>& r, const Patch<D>& patch, std::span<const NodalFacet<D>> made);

/// Facets of the patches of one round, which know nothing of one another.
template <int D>
class NewWalls {
  public:
    void clear();
    /// Takes the patch's facets, which are clear by themselves (are_walls_clear, or valid elements that keep their
    /// plane), unless they are not disjoint from those taken before.
    [[nodiscard]] bool take(const DynamicMesh<D>& mesh, const Patch<D>& patch);

  private:
    FacetGrid<D> grid_;
    std::vector<NodalFacet<D>> facets_;
    std::vector<FacetId> near_;
};

}  // namespace camber
