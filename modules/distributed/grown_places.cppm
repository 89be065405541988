module;
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.distributed:grown_places;
import camber.core;
import :ranks;
import :ringed_parts;
import :simplex_row;

namespace camber {

/// Sets of numbers from 0 on, each called by the lowest of them.
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    [[nodiscard]] std::size_t lowest(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void unite(std::size_t i, std::size_t j) {
        const auto [low, high] = std::minmax({lowest(i), lowest(j)});
        parent_[high] = low;
    }

  private:
    std::vector<std::size_t> parent_;
};

template <int D>
[[nodiscard]] std::vector<GlobalNumber> vertices_of(std::span<const SimplexRow<D>> rows) {
    std::vector<GlobalNumber> vertices;
    for (const auto& row : rows) vertices.insert(vertices.end(), row.vertices.begin(), row.vertices.end());
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    return vertices;
}

/// Elements with all within some rings around them.
template <int D>
struct GrownPlaces {
    std::vector<SimplexRow<D>> rows;  ///< rising
    std::vector<GlobalNumber> inner;  ///< vertices all of whose elements are here, rising
};

/// Around these elements, of all ranks: those that grow together are one place, which comes to the rank that has the
/// lowest of its elements among these. `balls`: of the parts here. Errors: of any rank.
template <int D>
[[nodiscard]] Outcome<GrownPlaces<D>> grown_places(const RingedParts<D>& parts,
                                                   std::span<const Incidence<ElementId>> balls,
                                                   const std::vector<GlobalNumber>& elements, int rings, Ranks& ranks);

}  // namespace camber
