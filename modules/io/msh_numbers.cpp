// Numbers of physical groups and entities in MSH files, and the sections that list them.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::msh {

namespace {

class FreeNumbers {
  public:
    explicit FreeNumbers(std::set<Reference>& used) : used_(used) {}
    Reference take() {
        while (!used_.insert(next_).second) ++next_;
        return next_;
    }

  private:
    std::set<Reference>& used_;
    Reference next_ = 1;
};

void find_classes(std::span<const Reference> references, std::span<const Reference> entities, Classes& classes) {
    std::unordered_map<std::uint64_t, std::uint32_t> rows;
    std::uint64_t last = 0;
    std::uint32_t row = no_row;
    classes.of.resize(references.size());
    for (std::size_t i = 0; i < references.size(); ++i) {
        const Reference entity = entities.empty() ? 0 : entities[i];
        const std::uint64_t key =
            std::uint64_t{static_cast<std::uint32_t>(entity)} << 32U | static_cast<std::uint32_t>(references[i]);
        if (row == no_row || key != last) {
            row = rows.try_emplace(key, static_cast<std::uint32_t>(classes.list.size())).first->second;
            last = key;
            if (row == classes.list.size()) classes.list.push_back({entity, references[i]});
        }
        ++classes.list[row].count;
        classes.of[i] = row;
    }
}

/// A positive reference is its own physical tag. References 0, −1, −2 … get free numbers in this order. With
/// `Unnumbered::in_no_group`, reference 0 gets no number if it has no name.
void number_references(std::span<const Reference> named, Unnumbered unnumbered, Classes& classes) {
    std::set<Reference> used;
    std::set<Reference, std::greater<>> others;
    const auto enter = [&](Reference reference) {
        if (reference > 0)
            used.insert(reference);
        else
            others.insert(reference);
    };
    for (const Class& one : classes.list) enter(one.reference);
    for (const Reference reference : named) enter(reference);
    FreeNumbers free(used);
    const bool is_named = std::ranges::find(named, 0) != named.end();
    if (unnumbered == Unnumbered::in_no_group && !is_named && others.erase(0) > 0) classes.physical_of[0] = 0;
    for (const Reference reference : others) classes.physical_of[reference] = free.take();
    for (Class& one : classes.list) one.physical = classes.physical(one.reference);
}

/// Gives each class an entity number that no class with another physical tag has. A class requests its positive entity,
/// or its physical tag if it has no entity. If several request a number, the class with the lowest physical tag gets
/// it, and the others get free numbers.
void number_entities(std::span<const Reference> places, Classes& classes) {
    std::vector<Class*> order;
    order.reserve(classes.list.size());
    for (Class& one : classes.list) order.push_back(&one);
    const auto rank = [](const Class* one) {  // first classes with a positive entity, then those without entity, then
                                              // those with a negative one
        return std::tuple(one->entity > 0 ? 0 : 1, one->entity > 0 ? one->entity : -(one->entity + 1), one->physical);
    };
    std::sort(order.begin(), order.end(), [&](const Class* a, const Class* b) { return rank(a) < rank(b); });
    std::map<Reference, Reference> physical_on;  // for each entity with simplices, its physical tag
    const auto takes = [&](Class& one, Reference tag) {
        const bool is_free = tag > 0 && physical_on.try_emplace(tag, one.physical).first->second == one.physical;
        if (is_free) one.tag = tag;
        return is_free;
    };
    std::vector<Class*> left;
    for (Class* one : order)
        if (one->entity < 0 || !takes(*one, one->entity > 0 ? one->entity : one->physical)) left.push_back(one);
    for (const auto& [tag, physical] : physical_on) classes.tags.insert(tag);
    std::set<Reference, std::greater<>> others;
    for (const Reference entity : places)
        if (entity > 0)
            classes.tags.insert(entity);
        else
            others.insert(entity);
    FreeNumbers free(classes.tags);
    for (Class* one : left) one->tag = free.take();
    for (const Reference entity : others) classes.tag_of[entity] = free.take();
}

template <int D>
Classes points_of(const LinearMesh<D>& mesh, std::span<const Reference> named, std::span<const Reference> places,
                  Numbers& numbers) {
    std::vector<Reference> references, entities;
    for (std::size_t v = 0; v < numbers.places.size(); ++v) {
        const Place place = numbers.places[v];
        if (place.dimension != 0 || mesh.point_references[v] <= 0) continue;
        numbers.points.push_back(static_cast<std::uint32_t>(v));
        references.push_back(mesh.point_references[v]);
        entities.push_back(entity_at(mesh, place));
    }
    return classes_of(references, entities, named, places);
}

}  // namespace

Classes classes_of(std::span<const Reference> references, std::span<const Reference> entities,
                   std::span<const Reference> named, std::span<const Reference> places, Unnumbered unnumbered) {
    Classes classes;
    find_classes(references, entities, classes);
    number_references(named, unnumbered, classes);
    number_entities(places, classes);
    return classes;
}

template <int D>
Buffer<Place> places_of(const LinearMesh<D>& mesh) {
    const InputGeometry<D>& input = mesh.geometry;
    if (input.on_points.empty() && input.on_curves.empty() && input.on_surfaces.empty()) return {};
    Buffer<Place> places(mesh.points.size(), Place{});
    const auto enter = [&](const auto& associations, int dimension) {
        for (std::size_t i = associations.size(); i-- > 0;)
            places[associations[i].item.index()] = {dimension, static_cast<std::uint32_t>(i)};
    };
    enter(input.on_surfaces, 2);
    enter(input.on_curves, 1);
    enter(input.on_points, 0);
    return places;
}

template <int D>
Numbers numbers_of(const LinearMesh<D>& mesh) {
    Numbers numbers;
    numbers.places = places_of(mesh);
    std::vector<std::vector<Reference>> named(4), on(4);
    for (const Group& group : mesh.groups)
        if (group.dimension >= 0 && group.dimension <= 3)
            named[static_cast<std::size_t>(group.dimension)].push_back(group.reference);
    for (std::size_t v = 0; v < numbers.places.size(); ++v) {
        const Place place = numbers.places[v];
        const bool is_point_element = place.dimension == 0 && mesh.point_references[v] > 0;
        if (place.dimension < 3 && !is_point_element)
            on[static_cast<std::size_t>(place.dimension)].push_back(entity_at(mesh, place));
    }
    numbers.of_dimension.resize(4);
    numbers.of_dimension[0] = points_of(mesh, named[0], on[0], numbers);
    with_each_dimension(mesh, [&](auto dimension, const auto& simplices) {
        constexpr auto k = static_cast<std::size_t>(dimension());
        // Solvers need groups of the simplices that they integrate over: volumes and their boundary, but not curves in
        // a tetrahedral mesh.
        const bool is_beside_volumes = k < D - 1 && mesh.elements.size() > 0;
        const auto unnumbered = is_beside_volumes ? Unnumbered::in_no_group : Unnumbered::grouped;
        numbers.of_dimension[k] =
            classes_of(simplices.references.view(), simplices.entities.view(), named[k], on[k], unnumbered);
    });
    for (std::size_t k = D + 1; k < 4; ++k) numbers.of_dimension[k] = classes_of({}, {}, named[k], on[k]);
    return numbers;
}

#define CAMBER_INSTANTIATE(D)                                  \
    template Buffer<Place> places_of<D>(const LinearMesh<D>&); \
    template Numbers numbers_of<D>(const LinearMesh<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

std::vector<Reference> main_tags(const GroupTags& groups, const Numbers& numbers, int dimension) {
    std::vector<Reference> tags;
    for (const Class& one : numbers.of_dimension[static_cast<std::size_t>(dimension)].list) {
        const std::vector<Reference> all = groups.of(dimension, one);
        tags.push_back(all.empty() ? 0 : all.front());
    }
    return tags;
}

void put_names(const GroupTags& groups, Sink& sink) {
    if (groups.named().empty()) return;
    sink.text("$PhysicalNames\n" + std::to_string(groups.named().size()) + "\n");
    for (const NamedTag& group : groups.named())
        sink.text(std::to_string(group.dimension) + " " + std::to_string(group.tag) + " " + "\"" + group.name + "\"" +
                  "\n");
    sink.text("$EndPhysicalNames\n");
}

void put_entities(const Layout& layout, Sink& sink) {
    sink.section("Entities");
    std::array<std::uint64_t, 4> counts{};
    for (const FileEntity& entity : layout.entities) ++counts[static_cast<std::size_t>(entity.dimension)];
    sink.line(counts[0], counts[1], counts[2], counts[3]);
    for (const FileEntity& entity : layout.entities) {
        const auto& [low, high] = entity.box;
        // Adding 0.0 turns −0 into 0, because the sign of zero depends on the order of threads.
        sink.words(entity.tag, low[0] + 0.0, low[1] + 0.0, low[2] + 0.0);
        if (entity.dimension > 0) sink.words(high[0] + 0.0, high[1] + 0.0, high[2] + 0.0);
        sink.words(std::uint64_t{entity.physicals.size()});
        for (const Reference physical : entity.physicals) sink.words(physical);
        if (entity.dimension > 0) sink.words(std::uint64_t{0});
        sink.end_line();
    }
    sink.end_section("Entities");
}

}  // namespace camber::msh
