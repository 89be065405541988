module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.crossing;
import camber.core;
import :facet_grid;

namespace camber {

namespace {

/// The least e with cells of 2^e larger than the box, but not so small that their numbers pass 2⁵⁰.
template <int D>
int exponent_for(const Box<D>& box) {
    double widest = 0, farthest = 0;
    for (int c = 0; c < D; ++c) {
        widest = std::max(widest, box.high[c] - box.low[c]);
        farthest = std::max({farthest, std::abs(box.low[c]), std::abs(box.high[c])});
    }
    const double least = std::max(widest, std::ldexp(farthest, -50));
    return least > 0 ? std::ilogb(least) + 1 : -1000;
}

}  // namespace

template <int D>
typename FacetGrid<D>::Cell FacetGrid<D>::cell_of(const Vec<D>& p, int exponent) {
    // Beyond what the cells' own facets reach numbers are cut off: no facet is there.
    Cell cell;
    for (int c = 0; c < D; ++c)
        cell[c] = static_cast<std::int64_t>(std::floor(std::clamp(std::ldexp(p[c], -exponent), -0x1p60, 0x1p60)));
    return cell;
}

template <int D>
std::uint32_t FacetGrid<D>::grid_for(const Box<D>& box) {
    const int exponent = exponent_for(box);
    for (std::size_t i = 0; i < grids_.size(); ++i)
        if (grids_[i].exponent == exponent) return static_cast<std::uint32_t>(i);
    grids_.push_back({.exponent = exponent, .first = {}, .members = {}});
    return static_cast<std::uint32_t>(grids_.size() - 1);
}

template <int D>
void FacetGrid<D>::insert(FacetId facet, const Box<D>& box) {
    remove(facet);
    if (facet.index() >= entries_.size()) entries_.resize(facet.index() + 1);
    const std::uint32_t at = grid_for(box);
    Grid& grid = grids_[at];
    std::uint32_t& first = grid.first.try_emplace(cell_of(box.low, grid.exponent), nowhere).first->second;
    Entry& entry = entries_[facet.index()];
    entry = {box, at, nowhere, first, static_cast<std::uint32_t>(grid.members.size())};
    if (first != nowhere) entries_[first].before = facet.value;
    first = facet.value;
    grid.members.push_back(facet.value);
    ++size_;
}

template <int D>
void FacetGrid<D>::remove(FacetId facet) {
    if (!contains(facet)) return;
    Entry& entry = entries_[facet.index()];
    Grid& grid = grids_[entry.grid];
    if (entry.after != nowhere) entries_[entry.after].before = entry.before;
    if (entry.before != nowhere) {
        entries_[entry.before].after = entry.after;
    } else {
        const auto cell = grid.first.find(cell_of(entry.box.low, grid.exponent));
        if (entry.after == nowhere)
            grid.first.erase(cell);
        else
            cell->second = entry.after;
    }
    grid.members[entry.place] = grid.members.back();
    entries_[grid.members.back()].place = entry.place;
    grid.members.pop_back();
    entry.grid = nowhere;
    --size_;
}

template <int D>
void FacetGrid<D>::look_into(const Grid& grid, const Box<D>& box, std::vector<FacetId>& found) const {
    const auto try_one = [&](std::uint32_t facet) {
        if (entries_[facet].box.meets(box)) found.push_back(FacetId(facet));
    };
    const Cell high = cell_of(box.high, grid.exponent);
    Cell low = cell_of(box.low, grid.exponent);
    double cells = 1;
    for (int c = 0; c < D; ++c) {
        --low[c];  // facets reach into the next cell
        cells *= static_cast<double>(high[c] - low[c] + 1);
    }
    if (cells > static_cast<double>(grid.members.size())) {
        for (const std::uint32_t facet : grid.members) try_one(facet);
        return;
    }
    Cell cell = low;
    while (true) {
        const auto list = grid.first.find(cell);
        if (list != grid.first.end())
            for (std::uint32_t facet = list->second; facet != nowhere; facet = entries_[facet].after) try_one(facet);
        int c = 0;
        while (c < D && cell[c] == high[c]) {
            cell[c] = low[c];
            ++c;
        }
        if (c == D) return;
        ++cell[c];
    }
}

template <int D>
void FacetGrid<D>::meeting(const Box<D>& box, std::vector<FacetId>& found) const {
    found.clear();
    for (const Grid& grid : grids_) look_into(grid, box, found);
    std::sort(found.begin(), found.end());
}

#define CAMBER_INSTANTIATE(D) template class FacetGrid<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
