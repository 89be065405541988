module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::msh {

namespace {

constexpr std::size_t row_grain = 8192;

void atomic_min(std::uint32_t& target, std::uint32_t value) {
    const std::atomic_ref<std::uint32_t> shared(target);
    std::uint32_t seen = shared.load(std::memory_order_relaxed);
    while (value < seen && !shared.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
    }
}

template <int D>
Vec<3> in_space(const Vec<D>& p) {
    Vec<3> q{};
    for (int c = 0; c < D; ++c) q[c] = p[c];
    return q;
}

template <class Mesh>
class Maker {
  public:
    static constexpr int D = Mesh::dimension;

    Maker(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups, const Execution& execution)
        : grid_(grid), numbers_(numbers), groups_(groups), execution_(execution) {}

    Outcome<Layout> make() && {
        list_entities();
        where_.resize(grid_.nodes(), no_row);
        Outcome<Done> done = Done{};
        with_each_dimension(grid_.linear(), [&](auto, const auto& simplices) {
            if (done) done = enter(simplices);
        });
        if (!done) return fail(std::move(done.error()));
        enter_places();
        enter_orphans();
        layout_.nodes = grouped(grid_.nodes(), 2 * layout_.entities.size(), [&](std::size_t n) {
            return 2 * std::size_t{where_[n]} + (has_parameters(n) ? 1 : 0);
        });
        return std::move(layout_);
    }

  private:
    void list_entities() {
        std::map<std::pair<int, Reference>, std::vector<Reference>> all;
        for (int k = 0; k < 4; ++k) {
            const Classes& classes = numbers_.of_dimension[static_cast<std::size_t>(k)];
            for (const Reference tag : classes.tags) all.try_emplace({k, tag});
            for (const Class& one : classes.list) all[{k, one.tag}] = groups_.of(k, one);
        }
        for (const auto& [key, physicals] : all) layout_.entities.push_back({key.first, key.second, physicals});
        for (int k = 0; k < 4; ++k)
            for (const Class& one : numbers_.of_dimension[static_cast<std::size_t>(k)].list)
                layout_.entity_of_class[static_cast<std::size_t>(k)].push_back(row_of(k, one.tag));
    }
    [[nodiscard]] std::uint32_t row_of(int dimension, Reference tag) const {
        const auto found = std::lower_bound(
            layout_.entities.begin(), layout_.entities.end(), std::pair(dimension, tag),
            [](const FileEntity& entity, const auto& key) { return std::pair(entity.dimension, entity.tag) < key; });
        return static_cast<std::uint32_t>(found - layout_.entities.begin());
    }

    /// The entity of simplices is that of their nodes, where no lower one is; and their nodes are in its box.
    template <int K>
    Outcome<Done> enter(const Simplices<K>& simplices) {
        const auto& of = numbers_.of_dimension[K].of;
        const auto& entity_of = layout_.entity_of_class[K];
        return each_chunk(
            execution_, simplices.size(),
            [&](std::size_t begin, std::size_t end) {
                Box<3> box;
                std::uint32_t at = no_row;
                for (std::size_t i = begin; i < end; ++i) {
                    const std::uint32_t entity = entity_of[of[i]];
                    if (entity != at) include(at, std::exchange(box, {}));
                    at = entity;
                    for (std::size_t n = 0; n < Grid<Mesh>::template width<K>; ++n) {
                        const std::size_t node = grid_.template node<K>(simplices, i, n);
                        atomic_min(where_[node], entity);
                        box.include(in_space(grid_.point(node)));
                    }
                }
                include(at, box);
            },
            row_grain);
    }
    void include(std::uint32_t entity, const Box<3>& box) {
        if (entity == no_row) return;
        const std::scoped_lock lock(boxes_);
        layout_.entities[entity].box.include(box);
    }

    void enter_places() {
        const auto& linear = grid_.linear();
        for (std::size_t v = 0; v < numbers_.places.size(); ++v) {
            const Place place = numbers_.places[v];
            if (place.dimension == 3) continue;
            const Classes& classes = numbers_.of_dimension[static_cast<std::size_t>(place.dimension)];
            if (place.dimension > 0 || linear.point_references[v] <= 0)
                put(v, row_of(place.dimension, classes.tag(entity_at(linear, place))));
        }
        const Classes& points = numbers_.of_dimension[0];
        for (std::size_t i = 0; i < numbers_.points.size(); ++i)
            put(numbers_.points[i], layout_.entity_of_class[0][points.of[i]]);
    }
    /// Vertices that nothing uses and that are on nothing are on the first volume.
    void enter_orphans() {
        if (std::find(where_.begin(), where_.end(), no_row) == where_.end()) return;
        const std::uint32_t volume = row_of(3, 1);
        if (volume == layout_.entities.size()) layout_.entities.push_back({3, 1});
        for (std::size_t v = 0; v < where_.size(); ++v)
            if (where_[v] == no_row) put(v, volume);
    }
    void put(std::size_t vertex, std::uint32_t entity) {
        where_[vertex] = entity;
        layout_.entities[entity].box.include(in_space(grid_.point(vertex)));
    }
    [[nodiscard]] bool has_parameters(std::size_t n) const {
        if (n >= numbers_.places.size()) return false;
        const auto& [dimension, row] = numbers_.places[n];
        const auto& geometry = grid_.linear().geometry;
        return (dimension == 1 && geometry.on_curves[row].parameters) ||
               (dimension == 2 && geometry.on_surfaces[row].parameters);
    }

    const Grid<Mesh>& grid_;
    const Numbers& numbers_;
    const GroupTags& groups_;
    const Execution& execution_;
    Layout layout_;
    Buffer<std::uint32_t> where_;  ///< the entity of each node
    std::mutex boxes_;
};

}  // namespace

template <class Mesh>
Outcome<Layout> layout_of(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups,
                          const Execution& execution) {
    return Maker<Mesh>(grid, numbers, groups, execution).make();
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<Layout> layout_of(const Grid<LinearMesh<D>>&, const Numbers&, const GroupTags&,    \
                                       const Execution&);                                               \
    template Outcome<Layout> layout_of(const Grid<QuadraticMesh<D>>&, const Numbers&, const GroupTags&, \
                                       const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::msh
