module;
#include "cgns_library.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :cgns_reader;

namespace camber::cgns {

namespace {

struct Condition {
    std::string name;
    std::optional<Reference> reference;
    std::vector<cgsize_t> items;
    bool is_range = false, of_elements = false;
};

template <int D>
struct ConditionReader {
    Reader<D>& of;
    std::size_t listed_again = 0;

    [[nodiscard]] Outcome<Condition> read_condition(int bc) {
        Name name{};
        CGNS_ENUMT(BCType_t) type{};
        CGNS_ENUMT(PointSetType_t) set{};
        CGNS_ENUMT(DataType_t) normal_type{};
        CGNS_ENUMT(GridLocation_t) location = CGNS_ENUMV(Vertex);
        cgsize_t n = 0, normals = 0;
        int normal_index[3]{}, datasets = 0;
        if (of.lib.boco_info_(of.file, 1, of.zone, bc, name.data(), &type, &set, &n, normal_index, &normals,
                              &normal_type, &datasets) != CG_OK ||
            n < 0 || !has_one_index_a_point(bc, n))
            return of.broken("boundary condition " + std::to_string(bc) + " cannot be read");
        static_cast<void>(of.lib.boco_gridlocation_read_(of.file, 1, of.zone, bc, &location));
        if (auto within_budget =
                of.take_budget(static_cast<std::size_t>(n), "boundary condition " + std::to_string(bc));
            !within_budget)
            return fail(within_budget.error());
        Condition condition{name.data(), {}, std::vector<cgsize_t>(static_cast<std::size_t>(n))};
        if (n > 0 && of.lib.boco_read_(of.file, 1, of.zone, bc, condition.items.data(), nullptr) != CG_OK)
            return of.broken("the points of boundary condition " + in_quotes(condition.name) + " cannot be read");
        if (of.lib.goto_(of.file, 1, "Zone_t", of.zone, "ZoneBC_t", 1, "BC_t", bc, "end") == CG_OK)
            condition.reference = of.described_reference();
        condition.is_range = set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(ElementRange);
        condition.of_elements =
            set == CGNS_ENUMV(ElementRange) || set == CGNS_ENUMV(ElementList) || location != CGNS_ENUMV(Vertex);
        if (condition.is_range && (n != 2 || condition.items[1] < condition.items[0])) condition.items.clear();
        return condition;
    }
    /// True if the point lists of condition `bc` contain exactly n numbers. `boco_read` writes all numbers of the file
    /// into the caller's array, even if the library reported a smaller number n.
    [[nodiscard]] bool has_one_index_a_point(int bc, cgsize_t n) const {
        double node = 0, points = 0;
        int cgio = 0;
        if (of.lib.boco_id_(of.file, 1, of.zone, bc, &node) != CG_OK || of.lib.get_cgio_(of.file, &cgio) != CG_OK)
            return false;
        for (const char* const child : {"PointList", "PointRange", "ElementList", "ElementRange"}) {
            if (of.lib.node_id(cgio, node, child, &points) != 0) continue;
            int dimensions = 0;
            std::array<cgsize_t, 12> sizes{};
            if (of.lib.node_dimensions(cgio, points, &dimensions, sizes.data()) != 0) return false;
            cgsize_t product = 1;
            for (int d = 0; d < dimensions; ++d) product *= sizes[static_cast<std::size_t>(d)];
            if (product != n || (dimensions > 1 && sizes[0] != 1)) return false;
        }
        return true;
    }

    bool mark(const Condition& condition, Reference reference) {
        std::size_t listed = 0;
        const auto enter = [&](Place& place) {
            if (place.dimension != of.cell_dimension - 1) return;
            listed_again += place.listed ? 1 : 0;
            reference_at(place) = reference;
            place.listed = true;
            ++listed;
        };
        if (condition.of_elements)
            each_element(condition, enter);
        else
            each_between_vertices(condition, enter);
        return listed > 0;
    }
    void each_element(const Condition& condition, const auto& enter) {
        for (Section& section : of.sections) {
            const cgsize_t last = section.first + static_cast<cgsize_t>(section.places.size()) - 1;
            const auto at = [&](cgsize_t e) -> Place& {
                return section.places[static_cast<std::size_t>(e - section.first)];
            };
            if (condition.is_range && condition.items.size() == 2) {
                const cgsize_t end = std::min(condition.items[1], last);
                for (cgsize_t e = std::max(condition.items[0], section.first); e <= end; ++e) enter(at(e));
                continue;
            }
            for (const cgsize_t e : condition.items)
                if (e >= section.first && e <= last) enter(at(e));
        }
    }
    void each_between_vertices(const Condition& condition, const auto& enter) {
        std::vector<std::uint8_t> listed(of.mesh.points.size(), 0);
        const auto list = [&](cgsize_t v) {
            if (const VertexId vertex = of.vertex(v); vertex.valid()) listed[vertex.index()] = 1;
        };
        if (condition.is_range && condition.items.size() == 2)
            for (cgsize_t v = std::max<cgsize_t>(1, condition.items[0]);
                 v <= condition.items[1] && std::cmp_less_equal(v, of.zone_points()); ++v)
                list(v);
        else
            std::for_each(condition.items.begin(), condition.items.end(), list);
        for (Section& section : of.sections)
            for (Place& place : section.places) {
                if (place.dimension != of.cell_dimension - 1) continue;
                const bool all = at_place(place, [&](auto& rows) {
                    const auto& nodes = rows.nodes[place.row];
                    return std::all_of(nodes.begin(), nodes.begin() + of.cell_dimension, [&](VertexId v) {
                        return v.valid() && v.index() < listed.size() && listed[v.index()] != 0;
                    });
                });
                if (all) enter(place);
            }
    }

    [[nodiscard]] Outcome<Done> read() {
        int n = 0;
        if (of.lib.nbocos_(of.file, 1, of.zone, &n) != CG_OK)
            return of.broken("the boundary conditions cannot be read");
        std::vector<Condition> conditions;
        std::set<Reference> taken;
        for (int bc = 1; bc <= n; ++bc) {
            auto condition = read_condition(bc);
            if (!condition) return fail(condition.error());
            if (condition->reference) taken.insert(*condition->reference);
            conditions.push_back(std::move(*condition));
        }
        for (const Section& section : of.sections)
            if (section.reference) taken.insert(*section.reference);
        take_known(of.cell_dimension - 1, taken);
        for (const Condition& condition : conditions) {
            const auto known = of.known_reference(of.cell_dimension - 1, condition.name);
            const Reference reference = condition.reference ? *condition.reference : known ? *known : next_free(taken);
            if (mark(condition, reference))
                name_group(of.cell_dimension - 1, reference, condition.name);
            else
                of.notices.push_back(
                    {"the boundary condition " + in_quotes(condition.name) + " contains no face of the mesh"});
        }
        if (listed_again > 0)
            of.notices.push_back({std::to_string(listed_again) +
                                  " faces are in several boundary conditions: the last one was used for each"});
        for (int k = D; k >= 1; --k) number_sections(k, k == of.cell_dimension - 1 ? taken : std::set<Reference>{});
        return Done{};
    }

    /// Assigns a reference to the simplices that no boundary condition lists:
    /// 1. the reference stored for their section;
    /// 2. else that of a group with the section's name, which an earlier zone added;
    /// 3. else the next free number.
    void number_sections(int dimension, std::set<Reference> taken) {
        for (const Section& section : of.sections)
            if (section.reference) taken.insert(*section.reference);
        take_known(dimension, taken);
        for (Section& section : of.sections) {
            const auto own = [&](const Place& p) { return p.dimension == dimension && !p.listed; };
            if (std::none_of(section.places.begin(), section.places.end(), own)) continue;
            const std::string name = (dimension == of.cell_dimension ? of.prefix : "") + section.name;
            const auto known = of.known_reference(dimension, name);
            const Reference reference = section.reference ? *section.reference : known ? *known : next_free(taken);
            for (const Place& place : section.places)
                if (own(place)) reference_at(place) = reference;
            name_group(dimension, reference, name);
        }
    }
    void take_known(int dimension, std::set<Reference>& taken) const {
        for (std::size_t g = 0; g < of.groups_before; ++g)
            if (of.mesh.groups[g].dimension == dimension) taken.insert(of.mesh.groups[g].reference);
    }
    static Reference next_free(std::set<Reference>& taken) {
        Reference next = 1;
        while (!taken.insert(next).second) ++next;
        return next;
    }
    auto at_place(const Place& place, auto&& f) {
        const auto of_kind = [&](auto& kind) { return place.degree == 1 ? f(kind.straight) : f(kind.curved); };
        if constexpr (D == 3)
            if (place.dimension == 1) return of_kind(of.mesh.edges);
        return place.dimension == D ? of_kind(of.mesh.elements) : of_kind(of.mesh.facets);
    }
    Reference& reference_at(const Place& place) {
        return *at_place(place, [&](auto& rows) { return &rows.references[place.row]; });
    }
    /// Adds a group, unless the reference already has a name or `name` is generated by `encode_cgns`.
    void name_group(int dimension, Reference reference, const std::string& name) {
        if (name == plain_name(dimension, reference)) return;
        for (const Group& group : of.mesh.groups)
            if (group.dimension == dimension && group.reference == reference) return;
        of.mesh.groups.push_back({dimension, reference, name});
    }
};

}  // namespace

template <int D>
Outcome<Done> read_conditions(Reader<D>& of) {
    return ConditionReader<D>{of}.read();
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> read_conditions<D>(Reader<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::cgns
