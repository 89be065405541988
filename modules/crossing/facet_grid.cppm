module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>
export module camber.crossing:facet_grid;
import camber.core;

export namespace camber {

/// Boxes of facets that come and go: which of them meet a box? A grid for each size of facets, its cells twice as large
/// from one to the next; a facet is in the cell of its lowest corner on the grid whose cells are just larger than its
/// box. A value; the answers depend on what is in it alone, not on the order in which it came.
template <int D>
class FacetGrid {
  public:
    /// A facet that is there already gets the new box. Coordinates must be finite.
    void insert(FacetId facet, const Box<D>& box);
    /// Nothing happens where it is not there.
    void remove(FacetId facet);

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool contains(FacetId facet) const {
        return facet.index() < entries_.size() && entries_[facet.index()].grid != nowhere;
    }
    [[nodiscard]] const Box<D>& box(FacetId facet) const { return entries_[facet.index()].box; }

    /// The facets whose boxes meet the box (touching is meeting), in rising order, in place of what `found` held.
    void meeting(const Box<D>& box, std::vector<FacetId>& found) const;

  private:
    static constexpr std::uint32_t nowhere = 0xffffffffU;
    using Cell = std::array<std::int64_t, D>;
    struct CellHash {
        std::size_t operator()(const Cell& cell) const {
            std::uint64_t h = 0;
            for (const std::int64_t x : cell) {
                h = (h ^ static_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15ULL;
                h ^= h >> 29U;
            }
            return h;
        }
    };
    /// The facets of one cell are a list through the entries.
    struct Entry {
        Box<D> box;
        std::uint32_t grid = nowhere;
        std::uint32_t before = nowhere, after = nowhere;
        std::uint32_t place = 0;  ///< in the grid's `members`
    };
    struct Grid {
        int exponent = 0;  ///< cells are 2^exponent wide
        std::unordered_map<Cell, std::uint32_t, CellHash> first;
        std::vector<std::uint32_t> members;
    };

    [[nodiscard]] static Cell cell_of(const Vec<D>& p, int exponent);
    [[nodiscard]] std::uint32_t grid_for(const Box<D>& box);
    void look_into(const Grid& grid, const Box<D>& box, std::vector<FacetId>& found) const;

    std::vector<Entry> entries_;  ///< by facet
    std::vector<Grid> grids_;
    std::size_t size_ = 0;
};

}  // namespace camber
