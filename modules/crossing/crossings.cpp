module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.crossing;
import camber.core;
import camber.bezier;
import :crossings;
import :facet;
import :pair;

namespace camber {

namespace {

Crossings joined(Crossings all, Crossings more) {
    all.pairs += more.pairs;
    all.crossing += more.crossing;
    all.undecided += more.undecided;
    all.found.insert(all.found.end(), more.found.begin(), more.found.end());
    return all;
}

void enter(Crossings& all, FacetId first, FacetId second, Crossing verdict) {
    if (verdict == Crossing::clear) return;
    ++(verdict == Crossing::crossing ? all.crossing : all.undecided);
    all.found.push_back({first, second, verdict});
}

/// What was found, and room for the facets near one, made once for many.
struct Looking {
    Crossings all;
    std::vector<std::uint32_t> others = {};
};

template <int D>
class Facets {
  public:
    Facets(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points, std::span<const LagrangeNode<D>> mid_nodes,
           std::span<const Box<D>> boxes)
        : mesh_(mesh), points_(points), mid_nodes_(mid_nodes), boxes_(boxes), tree_(boxes) {}

    /// Facet f with itself and with all that come after it.
    void look_at(std::size_t f, Looking& looking) const {
        auto& [all, others] = looking;
        const NodalFacet<D> facet = nodal(f);
        enter(all, FacetId(f), FacetId(f), crossing_of_itself(facet));
        others.clear();
        tree_.meeting(boxes_[f], [&](std::size_t g) {
            if (g > f && boxes_[g].meets(boxes_[f])) others.push_back(static_cast<std::uint32_t>(g));
        });
        std::sort(others.begin(), others.end());
        all.pairs += others.size();
        for (const std::uint32_t g : others) enter(all, FacetId(f), FacetId(g), crossing_of(facet, nodal(g)));
    }

  private:
    [[nodiscard]] NodalFacet<D> nodal(std::size_t f) const {
        return nodal_facet<D>(mesh_, points_, mid_nodes_, FacetId(f));
    }

    const QuadraticMesh<D>& mesh_;
    std::span<const Vec<D>> points_;
    std::span<const LagrangeNode<D>> mid_nodes_;
    std::span<const Box<D>> boxes_;
    BoxTree<D> tree_;
};

}  // namespace

template <int D>
Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, std::span<const Vec<D>> points,
                                  std::span<const LagrangeNode<D>> mid_nodes, const Execution& execution) {
    const std::size_t n = mesh.linear.facets.size();
    return guarded([&]() -> Outcome<Crossings> {
        auto boxes = map_each(part_of(execution, 0, 0.02), n, [&](std::size_t f) {
            return box_of(nodal_facet<D>(mesh, points, mid_nodes, FacetId(f)));
        });
        if (!boxes) return fail(boxes.error());
        const Facets<D> facets(mesh, points, mid_nodes, *boxes);
        auto looked = reduce_each(
            part_of(execution, 0.1, 1), n, Looking{},
            [&](Looking& looking, std::size_t f) { facets.look_at(f, looking); },
            [](Looking a, Looking b) { return Looking{joined(std::move(a.all), std::move(b.all))}; }, default_grain);
        if (!looked) return fail(looked.error());
        return std::move(looked->all);
    });
}

template <int D>
Outcome<Crossings> find_crossings(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return find_crossings<D>(mesh, mesh.linear.points.view(), mesh.mid_nodes.view(), execution);
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<Crossings> find_crossings<D>(const QuadraticMesh<D>&, std::span<const Vec<D>>,    \
                                                  std::span<const LagrangeNode<D>>, const Execution&); \
    template Outcome<Crossings> find_crossings<D>(const QuadraticMesh<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
