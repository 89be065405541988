module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import :msh_groups;

namespace camber::msh {

namespace {

using Tags = std::vector<Reference>;

constexpr std::array<std::string_view, 4> plurals{"points", "edges", "triangles", "tetrahedra"};

/// f(elements) with the rows of dimension K, of both degrees.
template <int K, class Elements, class F>
void with_rows_of(Elements& all, F&& f) {
    const auto visit = [&](auto& elements) {
        if constexpr (std::remove_cvref_t<decltype(elements)>::dimension == K) f(elements);
    };
    std::apply([&](auto&... elements) { (visit(elements), ...); }, all);
}

/// The first physical tag of a simplex, and the number of the set of its others.
using Key = std::pair<Reference, std::uint32_t>;
template <class Elements>
Key key_of(const Elements& elements, std::size_t row) {
    return {elements.physicals[row], elements.further[row]};
}

/// All tags of a simplex, the first one first.
Tags tags_of(const File& file, Key key) {
    Tags tags = file.further_groups.list[key.second];
    if (key.first != 0 || tags.empty()) tags.insert(tags.begin(), key.first);
    return tags;
}

/// Sets of tags of the simplices of one dimension, with the number of simplices.
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

/// The number after all that are in use; the smallest free one where there is none after.
Reference next_number(std::set<Reference>& used) {
    Reference next = 1;
    if (used.empty() || *used.rbegin() < std::numeric_limits<Reference>::max())
        next = used.empty() ? 1 : std::max(0, *used.rbegin()) + 1;
    else
        while (used.contains(next)) ++next;
    used.insert(next);
    return next;
}

/// References of sets with several tags, and all that is said of them.
class Assignment {
  public:
    Assignment(int dimension, const std::map<Tags, std::size_t>& sets, Buffer<Group>& groups,
               std::vector<Notice>& notices)
        : dimension_(dimension), groups_(groups), notices_(notices) {
        std::set<Reference> used, taken;
        for (const auto& [tags, count] : sets) used.insert(tags.begin(), tags.end());
        for (const Group& group : groups)
            if (group.dimension == dimension) used.insert(group.reference);
        for (const auto& [tags, count] : sets) {  // in lexicographical order
            const bool is_lowest = taken.insert(tags.front()).second;
            references_[tags] = is_lowest ? tags.front() : next_number(used);
            if (!is_lowest) tell(tags, count, references_[tags]);
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
    /// Gives the group a name if it has none.
    void name(Reference tag) {
        if (find(tag)) return;
        groups_.push_back({dimension_, tag, "group_" + std::to_string(tag)});
        notices_.push_back({"the physical group " + std::to_string(tag) + " shares " +
                            std::string(plurals[static_cast<std::size_t>(dimension_)]) +
                            " with others and has no name: it is called \"" + groups_.back().name + "\""});
    }
    void add_names(const Tags& tags, Reference reference) {
        if (tags.size() < 2) return;
        for (const Reference tag : tags)
            if (tag != reference) groups_.push_back({dimension_, reference, find(tag)->name});
    }
    void tell(const Tags& tags, std::size_t count, Reference reference) {
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
void give_references_of(File& file, Buffer<Group>& groups, std::vector<Notice>& notices) {
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

void give_references(File& file, Buffer<Group>& groups, std::vector<Notice>& notices) {
    if (file.further_groups.list.size() == 1) return;
    give_references_of<0>(file, groups, notices);
    give_references_of<1>(file, groups, notices);
    give_references_of<2>(file, groups, notices);
    give_references_of<3>(file, groups, notices);
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
    for (const auto& [key, all] : names) {  // in the order of references
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

}  // namespace camber::msh
