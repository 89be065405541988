module;
#include <algorithm>
#include <cstdint>
#include <vector>
module camber.repair:growth;
import camber.core;
import camber.bezier;
import camber.validity;
import :moved_mesh;

namespace camber {

/// Edges of a mesh that are chosen to have their nodes elsewhere, where `there` has them.
template <int D>
struct Growth {
    const MovedMesh<D>& moved;
    const Incidence<ElementId>& shells;
    const Column<EdgeKind>& kinds;  ///< nodes of volume edges may move
    const Overlay<EdgeId, LagrangeNode<D>>& there;
    SparseMap<EdgeId, std::uint8_t> chosen = {};  ///< 1: has its node of `there`
    std::vector<EdgeId> edges = {};               ///< those

    [[nodiscard]] bool is_chosen(EdgeId edge) const {
        const std::uint8_t* mark = chosen.find(edge);
        return mark && *mark == 1;
    }
    /// The element with the nodes that are chosen.
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> element = moved.element(e);
        const auto& edges_of = moved.mesh.edges.of_elements[e];
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (is_chosen(edges_of[i])) element.nodes[D + 1 + i] = there[edges_of[i]].point;
        return element;
    }
    [[nodiscard]] std::vector<ElementId> around(const std::vector<EdgeId>& some) const {
        std::vector<ElementId> elements;
        for (const EdgeId edge : some) elements.insert(elements.end(), shells[edge].begin(), shells[edge].end());
        std::ranges::sort(elements);
        elements.erase(std::ranges::unique(elements).begin(), elements.end());
        return elements;
    }
    void choose(EdgeId edge) {
        chosen.at(edge) = 1;
        edges.push_back(edge);
    }
    /// Its volume edges that are not chosen yet.
    std::vector<EdgeId> choose_all_of(ElementId e) {
        std::vector<EdgeId> added;
        for (const EdgeId edge : moved.mesh.edges.of_elements[e]) {
            if (kinds[edge] != EdgeKind::volume || is_chosen(edge)) continue;
            choose(edge);
            added.push_back(edge);
        }
        return added;
    }
};

/// Outwards: the nodes of the seeds, and those of whatever is not above the bound with the nodes chosen so far.
template <int D>
void grow(Growth<D>& growth, const std::vector<ElementId>& seeds, double bound) {
    std::vector<ElementId> queue = seeds;
    while (!queue.empty()) {
        std::vector<EdgeId> added;
        for (const ElementId e : queue) {
            const auto own = growth.choose_all_of(e);
            added.insert(added.end(), own.begin(), own.end());
        }
        queue.clear();
        for (const ElementId e : growth.around(added))
            if (decide(growth.element(e), bound) != Verdict::valid) queue.push_back(e);
    }
}

}  // namespace camber
