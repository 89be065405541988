module;
#include <cstddef>
#include <span>
#include <vector>
module camber.operation:walls;
import camber.core;
import camber.crossing;
import camber.cavity;
import :state;

/// Walls do not come to cross each other: neither positive volumes nor positive Jacobians of elements exclude it.
namespace camber {

/// Updates the boxes of facets after a commit.
template <int D>
void follow_walls(FacetGrid<D>& walls, const DynamicMesh<D>& mesh, const IdChanges<FacetId>& facets);

/// The facets that a patch would make; of a surface alone its triangles.
template <int D>
[[nodiscard]] std::vector<NodalFacet<D>> new_facets(const DynamicMesh<D>& mesh, const Patch<D>& patch);

/// True if every facet that a patch removes or makes lies in a plane of coordinates through its point, and every line
/// on such an axis: in one plane, or in those on both sides of a ridge. Valid elements make facets that, in a plane,
/// are positive too: each point of it is covered as often as the border winds around it. That border stays, and so no
/// facet comes where none was, nor covers another.
template <int D>
[[nodiscard]] bool keeps_its_planes(const DynamicMesh<D>& mesh, const Patch<D>& patch,
                                    std::span<const NodalFacet<D>> made);

/// True if the facets that a patch makes pass through neither each other nor the mesh's other facets. Curved facets
/// must be proved to be disjoint, each from itself too; straight ones may touch.
template <int D>
[[nodiscard]] bool are_walls_clear(const Adaptation<D>& r, const Patch<D>& patch, std::span<const NodalFacet<D>> made);

/// Facets of the patches of one round, which are planned independently of one another.
template <int D>
class NewWalls {
  public:
    void clear();
    /// Takes the patch's facets, which are clear by themselves (are_walls_clear, or valid elements that keep their
    /// planes). False if they are not clear of those taken before.
    [[nodiscard]] bool take(const DynamicMesh<D>& mesh, const Patch<D>& patch);

  private:
    FacetGrid<D> grid_;
    std::vector<NodalFacet<D>> facets_;
    std::vector<FacetId> near_;
};

}  // namespace camber
