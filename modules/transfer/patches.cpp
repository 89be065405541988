module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.transfer;
import :fields;
import :key_table;
import :materials;
import :patches;
import :same;
import :simplex;
import :sums;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
Changed find_changed(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const Same& same) {
    Changed changed;
    changed.is_free.assign(node_count_of(new_mesh, 2), 0);
    for (std::size_t e = 0; e < same.old_element.size(); ++e) {
        if (same.old_element[e] != none) continue;
        changed.new_elements.push_back(static_cast<std::uint32_t>(e));
        for (const std::size_t n : nodes_of<D, 2>(new_mesh, e)) changed.is_free[n] = 1;
    }
    for (std::size_t e = 0; e < same.old_element.size(); ++e)
        if (same.old_element[e] != none)
            for (const std::size_t n : nodes_of<D, 2>(new_mesh, e)) changed.is_free[n] = 0;
    changed.old_slot.assign(old_mesh.linear.elements.size(), none);
    for (std::size_t e = 0; e < same.is_kept.size(); ++e) {
        if (same.is_kept[e] != 0) continue;
        changed.old_slot[e] = static_cast<std::uint32_t>(changed.old_elements.size());
        changed.old_elements.push_back(static_cast<std::uint32_t>(e));
    }
    return changed;
}

// The sets' items: new slots, old slots, old nodes, new nodes.
template <int D>
PatchSearch<D>::PatchSearch(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const Same& same,
                            const Changed& changed)
    : changed_(changed),
      sets_(changed.new_elements.size() + changed.old_elements.size() + node_count_of(old_mesh, 2) +
            node_count_of(new_mesh, 2)) {
    const std::size_t first_old = changed.new_elements.size();
    const std::size_t old_nodes = first_old + changed.old_elements.size();
    const std::size_t new_nodes = old_nodes + node_count_of(old_mesh, 2);
    for (std::size_t slot = 0; slot < changed.new_elements.size(); ++slot)
        for (const std::size_t n : nodes_of<D, 2>(new_mesh, changed.new_elements[slot])) {
            if (n < new_mesh.linear.points.size() && changed.is_free[n] == 0) continue;
            const std::uint32_t old_node = same.old_node[n];
            sets_.join(slot, old_node == none ? new_nodes + n : old_nodes + old_node);
        }
    Buffer<std::uint8_t> is_kept(node_count_of(old_mesh, 2), 0);
    for (std::size_t e = 0; e < same.is_kept.size(); ++e)
        if (same.is_kept[e] != 0)
            for (const std::size_t n : nodes_of<D, 2>(old_mesh, e)) is_kept[n] = 1;
    for (std::size_t slot = 0; slot < changed.old_elements.size(); ++slot)
        for (const std::size_t n : nodes_of<D, 2>(old_mesh, changed.old_elements[slot]))
            if (n >= old_mesh.linear.points.size() || is_kept[n] == 0) sets_.join(first_old + slot, old_nodes + n);
}

template <int D>
auto PatchSearch<D>::patches(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                             const Materials<D>& materials) -> Patches {
    Patches out;
    const std::size_t first_old = changed_.new_elements.size();
    // The lowest item of a patch is its first new element; of a set without one an old element.
    std::vector<std::uint32_t> patch_of(first_old, none);
    std::vector<typename Patches::Group> of_new(first_old);
    for (std::size_t slot = 0; slot < first_old; ++slot) {
        const std::uint32_t lowest = sets_.lowest(static_cast<std::uint32_t>(slot));
        if (patch_of[lowest] == none) patch_of[lowest] = static_cast<std::uint32_t>(out.patches++);
        of_new[slot] = {patch_of[lowest],
                        static_cast<std::uint32_t>(materials.of(new_mesh.linear, changed_.new_elements[slot]))};
    }
    out.groups = of_new;
    std::ranges::sort(out.groups);
    const auto twice = std::ranges::unique(out.groups);
    out.groups.erase(twice.begin(), twice.end());
    const auto number = [&](const typename Patches::Group& group) {
        const auto at = std::ranges::lower_bound(out.groups, group);
        return at != out.groups.end() && *at == group ? static_cast<std::uint32_t>(at - out.groups.begin()) : no_group;
    };
    for (const auto& group : of_new) out.group_of_new.push_back(number(group));
    for (std::size_t slot = 0; slot < changed_.old_elements.size(); ++slot) {
        const std::uint32_t lowest = sets_.lowest(static_cast<std::uint32_t>(first_old + slot));
        const auto material = static_cast<std::uint32_t>(materials.of(old_mesh.linear, changed_.old_elements[slot]));
        out.group_of_old.push_back(lowest < first_old ? number({patch_of[lowest], material}) : no_group);
    }
    out.first_group.assign(out.patches + 1, 0);
    for (const auto& group : out.groups) ++out.first_group[group.patch + 1];
    for (std::size_t p = 0; p < out.patches; ++p) out.first_group[p + 1] += out.first_group[p];
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template Changed find_changed<D>(const QuadraticMesh<D>&, const QuadraticMesh<D>&, const Same&); \
    template class PatchSearch<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
