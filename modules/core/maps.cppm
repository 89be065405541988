module;
#include <cstddef>
#include <utility>
export module camber.core:maps;
import :column;
import :ids;

export namespace camber {

/// Where the entities of one kind went when a mesh changed: from their ids before to those after. The identity takes
/// no memory.
template <class EntityId>
class IdMap {
  public:
    IdMap() = default;
    /// Each of `count` entities keeps its id.
    [[nodiscard]] static IdMap identity(std::size_t count) {
        IdMap map;
        map.count_ = count;
        return map;
    }
    /// `after[old]`: invalid where the entity is gone.
    explicit IdMap(Column<EntityId> after) : after_(std::move(after)), count_(after_.size()), identity_(false) {}

    [[nodiscard]] EntityId operator[](EntityId old) const { return identity_ ? old : after_[old]; }
    [[nodiscard]] std::size_t size() const { return count_; }  ///< entities before

  private:
    Column<EntityId> after_;
    std::size_t count_ = 0;
    bool identity_ = true;
};

/// The maps of a commit, old → new, by which fields, metrics and whatever else is kept beside a mesh follow it.
struct MeshMaps {
    IdMap<VertexId> vertices;
    IdMap<EdgeId> edges;
    IdMap<ElementId> elements;
    IdMap<FacetId> facets;
};

}  // namespace camber
