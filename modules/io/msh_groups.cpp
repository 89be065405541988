// Physical groups of MSH files, and the layout of entities in MSH 4.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::msh {

namespace {

using Tags = std::vector<Reference>;

constexpr std::array<std::string_view, 4> plurals{"points", "edges", "triangles", "tetrahedra"};

template <int K, class Elements, class F>
void with_rows_of(Elements& all, F&& f) {
    const auto visit = [&](auto& elements) {
        if constexpr (std::remove_cvref_t<decltype(elements)>::dimension == K) f(elements);
    };
    std::apply([&](auto&... elements) { (visit(elements), ...); }, all);
}

using Key = std::pair<Reference, std::uint32_t>;
template <class Elements>
Key key_of(const Elements& elements, std::size_t row) {
    return {elements.physicals[row], elements.further[row]};
}

Tags tags_of(const File& file, Key key) {
    Tags tags = file.further_groups.list[key.second];
    if (key.first != 0 || tags.empty()) tags.insert(tags.begin(), key.first);
    return tags;
}

template <int K>
std::map<Tags, std::size_t> sets_of(const File& file) {
    std::map<Key, std::size_t> counts;
    with_rows_of<K>(file.elements, [&](const auto& elements) {
        for (std::size_t i = 0; i < elements.physicals.size(); ++i) ++counts[key_of(elements, i)];
    });
    std::map<Tags, std::size_t> sets;
    for (const auto& [key, count] : counts) sets[tags_of(file, key)] += count;
    return sets;
}

/// Returns one more than the largest used number. If that exceeds 32 bits, returns the smallest unused number.
Reference next_number(std::set<Reference>& used) {
    Reference next = 1;
    if (used.empty() || *used.rbegin() < std::numeric_limits<Reference>::max())
        next = used.empty() ? 1 : std::max(0, *used.rbegin()) + 1;
    else
        while (used.contains(next)) ++next;
    used.insert(next);
    return next;
}

class Assignment {
  public:
    Assignment(int dimension, const std::map<Tags, std::size_t>& sets, Buffer<Group>& groups,
               std::vector<Notice>& notices)
        : dimension_(dimension), groups_(groups), notices_(notices) {
        std::set<Reference> used, taken;
        for (const auto& [tags, count] : sets) used.insert(tags.begin(), tags.end());
        for (const Group& group : groups)
            if (group.dimension == dimension) used.insert(group.reference);
        for (const auto& [tags, count] : sets) {  // sets of tags in lexicographical order
            const bool is_lowest = taken.insert(tags.front()).second;
            references_[tags] = is_lowest ? tags.front() : next_number(used);
            if (!is_lowest) report_conflict(tags, count, references_[tags]);
        }
        for (const auto& [tags, reference] : references_)
            if (tags.size() > 1)
                for (const Reference tag : tags) name(tag);
        for (const auto& [tags, reference] : references_) add_names(tags, reference);
    }

    [[nodiscard]] Reference of(const Tags& tags) const { return references_.at(tags); }

  private:
    [[nodiscard]] const Group* find(Reference tag) const {
        const auto found = std::ranges::find_if(
            groups_, [&](const Group& g) { return g.dimension == dimension_ && g.reference == tag; });
        return found == groups_.end() ? nullptr : &*found;
    }
    void name(Reference tag) {
        if (find(tag)) return;
        groups_.push_back({dimension_, tag, "group_" + std::to_string(tag)});
        notices_.push_back({"the physical group " + std::to_string(tag) + " shares " +
                            std::string(plurals[static_cast<std::size_t>(dimension_)]) +
                            " with others and has no name. It gets the name \"" + groups_.back().name + "\""});
    }
    void add_names(const Tags& tags, Reference reference) {
        if (tags.size() < 2) return;
        for (const Reference tag : tags)
            if (tag != reference) groups_.push_back({dimension_, reference, find(tag)->name});
    }
    void report_conflict(const Tags& tags, std::size_t count, Reference reference) {
        std::string of;
        for (std::size_t i = 0; i < tags.size(); ++i)
            of += (i == 0 ? "" : i + 1 < tags.size() ? ", " : " and ") + std::to_string(tags[i]);
        notices_.push_back({std::to_string(count) + " " + std::string(plurals[static_cast<std::size_t>(dimension_)]) +
                            " in the physical groups " + of + " have the reference " + std::to_string(reference)});
    }

    int dimension_;
    Buffer<Group>& groups_;
    std::vector<Notice>& notices_;
    std::map<Tags, Reference> references_;
};

template <int K>
void assign_references_of(File& file, Buffer<Group>& groups, std::vector<Notice>& notices) {
    const auto sets = sets_of<K>(file);
    if (std::ranges::all_of(sets, [](const auto& set) { return set.first.size() == 1; })) return;
    const Assignment references(K, sets, groups, notices);
    std::map<Key, Reference> of_key;
    with_rows_of<K>(file.elements, [&](auto& elements) {
        for (std::size_t i = 0; i < elements.physicals.size(); ++i) {
            const Key key = key_of(elements, i);
            const auto [known, is_new] = of_key.try_emplace(key, 0);
            if (is_new) known->second = references.of(tags_of(file, key));
            elements.physicals[i] = known->second;
        }
    });
}

}  // namespace

void assign_references(File& file, Buffer<Group>& groups, std::vector<Notice>& notices) {
    if (file.further_groups.list.size() == 1) return;
    assign_references_of<0>(file, groups, notices);
    assign_references_of<1>(file, groups, notices);
    assign_references_of<2>(file, groups, notices);
    assign_references_of<3>(file, groups, notices);
}

GroupTags::GroupTags(const Column<Group>& groups, const Numbers& numbers) {
    using Numbered = std::pair<int, Reference>;
    std::map<Numbered, std::vector<std::string>> names;
    for (const Group& group : groups) names[{group.dimension, group.reference}].push_back(group.name);
    std::map<std::pair<int, std::string>, Reference> tags;
    std::array<std::set<Reference>, 4> used;
    const auto number = [&](const Numbered& key) {
        return numbers.of_dimension[static_cast<std::size_t>(key.first)].physical(key.second);
    };
    for (const auto& [key, all] : names) {  // in ascending order of references
        used[static_cast<std::size_t>(key.first)].insert(number(key));
        tags.try_emplace({key.first, all.front()}, number(key));
    }
    for (std::size_t k = 0; k < used.size(); ++k)
        for (const Class& one : numbers.of_dimension[k].list) used[k].insert(one.physical);
    std::set<Numbered> listed;
    for (const Group& group : groups) {
        const Numbered key{group.dimension, group.reference};
        Reference tag = number(key);
        if (names[key].size() > 1) {
            const auto [known, is_new] = tags.try_emplace({group.dimension, group.name}, 0);
            if (is_new) known->second = next_number(used[static_cast<std::size_t>(group.dimension)]);
            tag = known->second;
            if (auto& of = of_several_[key]; std::ranges::find(of, tag) == of.end()) of.push_back(tag);
        }
        if (listed.insert({group.dimension, tag}).second) named_.push_back({group.dimension, tag, group.name});
    }
}

std::vector<Reference> GroupTags::of(int dimension, const Class& simplices) const {
    const auto found = of_several_.find({dimension, simplices.reference});
    if (found != of_several_.end()) return found->second;
    return simplices.physical == 0 ? std::vector<Reference>{} : std::vector{simplices.physical};
}

namespace {

constexpr std::size_t row_grain = 8192;

void atomic_min(std::uint32_t& target, std::uint32_t value) {
    const std::atomic_ref<std::uint32_t> shared(target);
    std::uint32_t observed = shared.load(std::memory_order_relaxed);
    while (value < observed && !shared.compare_exchange_weak(observed, value, std::memory_order_relaxed)) {
    }
}

template <int D>
Vec<3> in_space(const Vec<D>& p) {
    Vec<3> q{};
    for (int c = 0; c < D; ++c) q[c] = p[c];
    return q;
}

template <class Mesh>
class LayoutBuilder {
  public:
    static constexpr int D = Mesh::dimension;

    LayoutBuilder(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups, const Execution& execution)
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
        classify_unused_vertices();
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

    /// Assigns the nodes of simplices to the entity of their simplex, unless they are already on an entity of lower
    /// dimension. Extends the entity's box.
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
    void classify_unused_vertices() {
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
    Buffer<std::uint32_t> where_;
    std::mutex boxes_;
};

}  // namespace

template <class Mesh>
Outcome<Layout> layout_of(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups,
                          const Execution& execution) {
    return LayoutBuilder<Mesh>(grid, numbers, groups, execution).make();
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
