module;
#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.surface:given_directions;
import camber.core;

namespace camber {

/// Directions that the mesh's maker gave, by vertex; rows that the table does not have are left out.
template <int D>
class GivenAtVertices {
  public:
    explicit GivenAtVertices(const DirectionsAtVertices<D>& given) : table_(given.table) {
        for (const DirectionRow& at : given.at)
            if (at.row < table_.size()) sorted_.push_back(at);
        std::sort(sorted_.begin(), sorted_.end(), [](const DirectionRow& a, const DirectionRow& b) {
            return std::pair(a.vertex, a.row) < std::pair(b.vertex, b.row);
        });
    }

    /// The vertex's rows, in their order.
    [[nodiscard]] std::span<const DirectionRow> of(VertexId v) const {
        const auto begin = std::lower_bound(sorted_.begin(), sorted_.end(), v,
                                            [](const DirectionRow& at, VertexId w) { return at.vertex < w; });
        auto end = begin;
        while (end != sorted_.end() && end->vertex == v) ++end;
        return {begin, end};
    }
    [[nodiscard]] Vec<D> unit(const DirectionRow& at) const { return normalised(table_[at.row]); }

  private:
    Column<Vec<D>> table_;
    std::vector<DirectionRow> sorted_;  ///< by rising vertex, then row
};

}  // namespace camber
