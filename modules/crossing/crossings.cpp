// Facet crossings of a mesh, and a dynamic grid of facets.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.crossing;
import camber.core;
import camber.box_tree;
import camber.bezier;

namespace camber {

namespace {

/// Minimum exponent e such that cells of size 2^e are larger than the box, and cell numbers are at most 2⁵⁰.
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
    // Clamping affects only numbers beyond all cells with facets.
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
    std::uint32_t& first = grid.first.try_emplace(cell_of(box.low, grid.exponent), no_entry).first->second;
    Entry& entry = entries_[facet.index()];
    entry = {box, at, no_entry, first, static_cast<std::uint32_t>(grid.members.size())};
    if (first != no_entry) entries_[first].before = facet.value;
    first = facet.value;
    grid.members.push_back(facet.value);
    ++size_;
}

template <int D>
void FacetGrid<D>::remove(FacetId facet) {
    if (!contains(facet)) return;
    Entry& entry = entries_[facet.index()];
    Grid& grid = grids_[entry.grid];
    if (entry.after != no_entry) entries_[entry.after].before = entry.before;
    if (entry.before != no_entry) {
        entries_[entry.before].after = entry.after;
    } else {
        const auto cell = grid.first.find(cell_of(entry.box.low, grid.exponent));
        if (entry.after == no_entry)
            grid.first.erase(cell);
        else
            cell->second = entry.after;
    }
    grid.members[entry.place] = grid.members.back();
    entries_[grid.members.back()].place = entry.place;
    grid.members.pop_back();
    entry.grid = no_entry;
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
        --low[c];  // facets of one cell can extend into the next cell
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
            for (std::uint32_t facet = list->second; facet != no_entry; facet = entries_[facet].after) try_one(facet);
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

namespace {

struct OpenPair {
    FacetId first, second;
};

struct CrossingSearch {
    Crossings all = {};
    std::vector<OpenPair> open = {};
    std::vector<std::uint32_t> others = {};

    void enter(FacetId first, FacetId second, const CrossingResult& judgement) {
        all.steps += static_cast<std::size_t>(judgement.steps);
        if (judgement.cut_short)
            open.push_back({first, second});
        else if (judgement.verdict != Crossing::disjoint)
            all.found.push_back({first, second, judgement.verdict});
    }
    friend CrossingSearch operator+(CrossingSearch a, const CrossingSearch& b) {
        a.all.pairs += b.all.pairs;
        a.all.steps += b.all.steps;
        a.all.found.insert(a.all.found.end(), b.all.found.begin(), b.all.found.end());
        a.open.insert(a.open.end(), b.open.begin(), b.open.end());
        return a;
    }
};

template <int D, class NodalOf>
class Facets {
  public:
    Facets(const NodalOf& nodal, std::span<const Box<D>> boxes) : nodal_(nodal), boxes_(boxes), tree_(boxes) {}

    void look_at(std::size_t f, int effort, CrossingSearch& looking) const {
        auto& [all, open, others] = looking;
        const NodalFacet<D> facet = nodal(FacetId(f));
        looking.enter(FacetId(f), FacetId(f), test_self_crossing(facet, effort));
        others.clear();
        tree_.meeting(boxes_[f], [&](std::size_t g) {
            if (g > f && boxes_[g].meets(boxes_[f])) others.push_back(static_cast<std::uint32_t>(g));
        });
        std::sort(others.begin(), others.end());
        all.pairs += others.size();
        for (const std::uint32_t g : others)
            looking.enter(FacetId(f), FacetId(g), test_pair(facet, nodal(FacetId(g)), effort));
    }

    void look_again(const OpenPair& pair, int effort, CrossingSearch& looking) const {
        looking.enter(pair.first, pair.second,
                      pair.first == pair.second ? test_self_crossing(nodal(pair.first), effort)
                                                : test_pair(nodal(pair.first), nodal(pair.second), effort));
    }

  private:
    [[nodiscard]] NodalFacet<D> nodal(FacetId f) const { return nodal_(f); }

    const NodalOf& nodal_;
    std::span<const Box<D>> boxes_;
    BoxTree<D> tree_;
};

constexpr int first_effort = 4;
constexpr std::size_t growth = 8;

/// Repeats the tests of undecided pairs with increasing effort, until `work` pairs of pieces are tested. The effort
/// depends on counts only, not on threads.
template <class AllFacets>
Outcome<CrossingSearch> refine_search(const AllFacets& facets, CrossingSearch looking, std::size_t work,
                                      const Execution& execution) {
    std::size_t effort = first_effort;
    while (!looking.open.empty() && effort < default_effort) {
        const std::size_t share = work / looking.open.size();
        if (share <= effort) break;
        effort = std::min({effort * growth, share, static_cast<std::size_t>(default_effort)});
        const std::vector<OpenPair> open = std::exchange(looking.open, {});
        auto again = reduce_each(
            execution, open.size(), CrossingSearch{},
            [&](CrossingSearch& l, std::size_t i) { facets.look_again(open[i], static_cast<int>(effort), l); },
            [](CrossingSearch a, const CrossingSearch& b) { return std::move(a) + b; }, 16);
        if (!again) return fail(again.error());
        work -= std::min(work, again->all.steps);
        looking = std::move(looking) + *again;
    }
    return looking;
}

Crossings crossings_from(CrossingSearch looking) {
    Crossings all = std::move(looking.all);
    all.cut_short = looking.open.size();
    for (const OpenPair& pair : looking.open) all.found.push_back({pair.first, pair.second, Crossing::undecided});
    std::sort(all.found.begin(), all.found.end(), [](const FacetCrossing& a, const FacetCrossing& b) {
        return std::pair(a.first, a.second) < std::pair(b.first, b.second);
    });
    for (const FacetCrossing& pair : all.found) {
        all.crossing += pair.verdict == Crossing::crossing ? 1 : 0;
        all.touching += pair.verdict == Crossing::touching ? 1 : 0;
        all.undecided += pair.verdict == Crossing::undecided ? 1 : 0;
    }
    return all;
}

template <int D, class NodalOf>
Outcome<Crossings> crossings_of(std::size_t n, const NodalOf& nodal, const Execution& execution) {
    return guarded([&]() -> Outcome<Crossings> {
        auto boxes = map_each(part_of(execution, 0, 0.02), n, [&](std::size_t f) { return box_of(nodal(FacetId(f))); });
        if (!boxes) return fail(boxes.error());
        const Facets<D, NodalOf> facets(nodal, *boxes);
        auto looked = reduce_each(
            part_of(execution, 0.1, 0.9), n, CrossingSearch{},
            [&](CrossingSearch& looking, std::size_t f) { facets.look_at(f, first_effort, looking); },
            [](CrossingSearch a, const CrossingSearch& b) { return std::move(a) + b; }, default_grain);
        if (!looked) return fail(looked.error());
        auto closer = refine_search(facets, std::move(*looked), max_steps(n), without_progress(execution));
        if (!closer) return fail(closer.error());
        return crossings_from(std::move(*closer));
    });
}

}  // namespace

template <int D>
Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                  std::span<const LagrangeNode<D>> mid_nodes, const Execution& execution) {
    const auto nodal = [&](FacetId f) { return nodal_facet<D>(mesh, points, mid_nodes, f); };
    return crossings_of<D>(mesh.linear.facets.size(), nodal, execution);
}

template <int D>
Outcome<Crossings> find_crossings(const LinearMesh<D>& mesh, const Execution& execution) {
    const auto nodal = [&](FacetId f) {
        std::array<Vec<D>, D> corners;
        for (int i = 0; i < D; ++i) corners[i] = mesh.points[mesh.facets.vertices[f][i]];
        return straight_facet<D>(corners);
    };
    return crossings_of<D>(mesh.facets.size(), nodal, execution);
}

template <int D>
Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return find_crossings<D>(mesh, mesh.linear.points.view(), mesh.mid_nodes.view(), execution);
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template class FacetGrid<D>;                                                                       \
    template Outcome<Crossings> find_crossings<D>(const QuadraticMesh<D>&, std::span<const Vec<D>>,    \
                                                  std::span<const LagrangeNode<D>>, const Execution&); \
    template Outcome<Crossings> find_crossings<D>(const QuadraticMesh<D>&, const Execution&);          \
    template Outcome<Crossings> find_crossings<D>(const LinearMesh<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
