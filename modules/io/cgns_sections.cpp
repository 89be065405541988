// Reads element sections and flow solutions of CGNS files.
module;
#include "cgns_library.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :cgns_reader;

namespace camber::cgns {

namespace {

template <int D>
struct SectionReader {
    Reader<D>& of;

    template <int K>
    [[nodiscard]] listing::Simplices<K>* simplices() {
        if constexpr (K == D) return &of.mesh.elements;
        if constexpr (K == D - 1) return &of.mesh.facets;
        if constexpr (K == 1 && D == 3) return &of.mesh.edges;
        return nullptr;
    }

    template <int N>
    std::array<VertexId, N> nodes_of(const cgsize_t* nodes) const {
        std::array<VertexId, N> simplex;
        for (int n = 0; n < N; ++n) simplex[n] = of.vertex(nodes[n]);
        return simplex;
    }

    template <int K>
    void add(listing::Simplices<K>& kind, int degree, const cgsize_t* nodes, Section& section) {
        std::size_t row = 0;
        const auto put = [&](auto& rows, auto simplex) {
            row = rows.size();
            rows.nodes.push_back(simplex);
            rows.references.push_back(0);
        };
        if (degree == 1)
            put(kind.straight, nodes_of<K + 1>(nodes));
        else
            put(kind.curved, nodes_of<quadratic_nodes<K>>(nodes));
        section.places.push_back({K, static_cast<std::int8_t>(degree), false, static_cast<std::uint32_t>(row)});
    }

    bool add_element(CGNS_ENUMT(ElementType_t) type, const cgsize_t* nodes, Section& section) {
        switch (type) {
            case CGNS_ENUMV(BAR_2): return add_simplex<1>(1, nodes, section);
            case CGNS_ENUMV(BAR_3): return add_simplex<1>(2, nodes, section);
            case CGNS_ENUMV(TRI_3): return add_simplex<2>(1, nodes, section);
            case CGNS_ENUMV(TRI_6): return add_simplex<2>(2, nodes, section);
            case CGNS_ENUMV(TETRA_4): return add_simplex<3>(1, nodes, section);
            case CGNS_ENUMV(TETRA_10): return add_simplex<3>(2, nodes, section);
            default: return false;
        }
    }
    template <int K>
    bool add_simplex(int degree, const cgsize_t* nodes, Section& section) {
        if constexpr (K > D) {
            return false;
        } else {
            add(*simplices<K>(), degree, nodes, section);
            return true;
        }
    }
    void skip(CGNS_ENUMT(ElementType_t) type, Section& section) {
        section.places.emplace_back();
        if (type == CGNS_ENUMV(NODE))
            ++of.points_listed;
        else
            of.refused.count(of.lib.ElementTypeName_(type));
    }

    [[nodiscard]] Outcome<Done> read_section(int s) {
        Name name{};
        CGNS_ENUMT(ElementType_t) type{};
        cgsize_t first = 0, last = 0, size = 0;
        int boundary = 0, parents = 0;
        if (of.lib.section_read_(of.file, 1, of.zone, s, name.data(), &type, &first, &last, &boundary, &parents) !=
                CG_OK ||
            of.lib.ElementDataSize_(of.file, 1, of.zone, s, &size) != CG_OK || first < 1 || last < first ||
            last == std::numeric_limits<cgsize_t>::max() || size < 0)
            return of.broken("section " + std::to_string(s) + " cannot be read");
        const auto n = static_cast<std::size_t>(last - first) + 1;
        Section section{name.data(), {}, first};
        if (of.lib.goto_(of.file, 1, "Zone_t", of.zone, "Elements_t", s, "end") == CG_OK)
            section.reference = of.described_reference();
        const bool fixed = type != CGNS_ENUMV(MIXED) && type < CGNS_ENUMV(NGON_n);
        if (!fixed && type != CGNS_ENUMV(MIXED)) {
            of.refused.count(of.lib.ElementTypeName_(type), n);
            return Done{};
        }
        int width = 0;
        if (fixed && (of.lib.npe_(type, &width) != CG_OK ||
                      static_cast<std::size_t>(size) != n * static_cast<std::size_t>(width)))
            return of.broken("section " + std::to_string(s) + " has " + std::to_string(size) + " numbers for " +
                             std::to_string(n) + " elements");
        if (!fixed && n > static_cast<std::size_t>(size) / 2)
            return of.broken("section " + std::to_string(s) + " has " + std::to_string(size) + " numbers for " +
                             std::to_string(n) + " elements");
        if (auto within_budget = of.take_budget(static_cast<std::size_t>(size) + n, "section " + std::to_string(s));
            !within_budget)
            return within_budget;
        // The null pointers stand for the offsets of elements. The library would not limit the number of offsets that
        // it writes for a damaged file.
        std::vector<cgsize_t> numbers(static_cast<std::size_t>(size));
        const int read = fixed ? of.lib.elements_read_(of.file, 1, of.zone, s, numbers.data(), nullptr)
                               : of.lib.poly_elements_read_(of.file, 1, of.zone, s, numbers.data(), nullptr, nullptr);
        if (read != CG_OK) return of.broken("the elements of section " + std::to_string(s) + " cannot be read");
        section.places.reserve(n);
        if (auto done = fixed ? add_fixed(type, static_cast<std::size_t>(width), numbers, section)
                              : add_mixed(numbers, n, section);
            !done)
            return done;
        of.sections.push_back(std::move(section));
        return Done{};
    }
    Outcome<Done> add_fixed(CGNS_ENUMT(ElementType_t) type, std::size_t width, std::span<const cgsize_t> numbers,
                            Section& section) {
        for (std::size_t at = 0; at + width <= numbers.size(); at += width)
            if (!add_element(type, numbers.data() + at, section)) skip(type, section);
        return Done{};
    }
    Outcome<Done> add_mixed(std::span<const cgsize_t> numbers, std::size_t n, Section& section) {
        std::size_t at = 0;
        for (std::size_t i = 0; i < n; ++i) {
            int width = 0;
            const auto type =
                at < numbers.size() ? static_cast<CGNS_ENUMT(ElementType_t)>(numbers[at]) : CGNS_ENUMV(ElementTypeNull);
            const bool is_cell = type > CGNS_ENUMV(ElementTypeUserDefined) && type != CGNS_ENUMV(MIXED) &&
                                 type != CGNS_ENUMV(NGON_n) && type != CGNS_ENUMV(NFACE_n);
            if (!is_cell || of.lib.npe_(type, &width) != CG_OK || width < 1 ||
                at + 1 + static_cast<std::size_t>(width) > numbers.size())
                return damaged(section, i + 1);
            if (!add_element(type, numbers.data() + at + 1, section)) skip(type, section);
            at += 1 + static_cast<std::size_t>(width);
        }
        return at == numbers.size() ? Outcome<Done>(Done{}) : damaged(section, n);
    }
    [[nodiscard]] Outcome<Done> damaged(const Section& section, std::size_t element) const {
        return fail(ErrorKind::input, "the mixed section " + in_quotes(section.name) + " is damaged", of.mesh.name,
                    Entity{"element", element}, "check the file with cgnscheck");
    }
};

}  // namespace

template <int D>
Outcome<Done> read_sections(Reader<D>& of) {
    SectionReader<D> sections{of};
    int n = 0;
    if (of.lib.nsections_(of.file, 1, of.zone, &n) != CG_OK) return of.broken("the sections cannot be read");
    for (int s = 1; s <= n; ++s)
        if (auto done = sections.read_section(s); !done) return done;
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> read_sections<D>(Reader<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

// Reading of flow solutions.

namespace {

/// Adds the field `name`. If it is the first component of a vector, adds the vector; if it is another component, adds
/// nothing.
template <int D>
void add_field(const Reader<D>& of, const std::string& name, const std::map<std::string, Column<double>>& scalars,
               std::vector<MeshField>& fields) {
    constexpr std::string_view axes = "XYZ";
    const std::string stem = name.substr(0, name.size() - 1);
    const auto whole_vector = [&] {
        for (int c = 0; c < D; ++c)
            if (!scalars.contains(stem + axes[static_cast<std::size_t>(c)])) return false;
        return !stem.empty();
    }();
    const std::size_t axis = axes.substr(0, D).find(name.back());
    if (!whole_vector || axis == std::string_view::npos) {
        fields.push_back({name, Centring::node, FieldKind::scalar, scalars.at(name)});
        return;
    }
    if (axis != 0) return;
    Buffer<double> values(of.mesh.points.size() * D);
    for (int c = 0; c < D; ++c) {
        const Column<double>& column = scalars.at(stem + axes[static_cast<std::size_t>(c)]);
        for (std::size_t v = 0; v < column.size(); ++v) values[v * D + static_cast<std::size_t>(c)] = column[v];
    }
    fields.push_back({stem, Centring::node, FieldKind::vector, Column<double>(std::move(values))});
}

}  // namespace

template <int D>
Outcome<Done> read_fields(Reader<D>& of) {
    // Fields of joined zones are not supported: the values of all zones would have to be combined.
    if (of.zone_points() != of.mesh.points.size()) return Done{};
    int solutions = 0;
    if (of.lib.nsols_(of.file, 1, of.zone, &solutions) != CG_OK) return of.broken("the solutions cannot be read");
    std::map<std::string, Column<double>> scalars;
    std::vector<std::string> order;
    for (int s = 1; s <= solutions; ++s) {
        Name name{};
        CGNS_ENUMT(GridLocation_t) location{};
        int fields = 0;
        if (of.lib.sol_info_(of.file, 1, of.zone, s, name.data(), &location) != CG_OK ||
            of.lib.nfields_(of.file, 1, of.zone, s, &fields) != CG_OK)
            return of.broken("solution " + std::to_string(s) + " cannot be read");
        int dimensions = 0;
        cgsize_t sizes[3]{};
        const bool at_vertices = location == CGNS_ENUMV(Vertex) &&
                                 of.lib.sol_size_(of.file, 1, of.zone, s, &dimensions, sizes) == CG_OK &&
                                 dimensions == 1 && static_cast<std::size_t>(sizes[0]) == of.mesh.points.size();
        if (!at_vertices && fields > 0) {
            of.notices.push_back({"the " + std::to_string(fields) + " fields of the solution " +
                                  in_quotes(name.data()) + " do not have values at all vertices and were skipped"});
            continue;
        }
        for (int f = 1; f <= fields; ++f) {
            CGNS_ENUMT(DataType_t) type{};
            Name field{};
            if (auto within_budget = of.take_budget(of.mesh.points.size(), "field " + std::to_string(f));
                !within_budget)
                return within_budget;
            Buffer<double> values(of.mesh.points.size());
            const cgsize_t first = 1, last = static_cast<cgsize_t>(of.mesh.points.size());
            if (of.lib.field_info_(of.file, 1, of.zone, s, f, &type, field.data()) != CG_OK ||
                of.lib.field_read_(of.file, 1, of.zone, s, field.data(), CGNS_ENUMV(RealDouble), &first, &last,
                                   values.data()) != CG_OK)
                return of.broken("field " + std::to_string(f) + " cannot be read");
            if (type != CGNS_ENUMV(RealDouble) && type != CGNS_ENUMV(RealSingle) && type != CGNS_ENUMV(Integer) &&
                type != CGNS_ENUMV(LongInteger)) {
                of.notices.push_back({"the field " + in_quotes(field.data()) +
                                      " does not have real numbers and was "
                                      "left out"});
                continue;
            }
            if (scalars.contains(field.data()))
                of.notices.push_back(
                    {"the field " + in_quotes(field.data()) + " is in several solutions: the last one was used"});
            else
                order.emplace_back(field.data());
            scalars.insert_or_assign(field.data(), Column<double>(std::move(values)));
        }
    }
    std::vector<MeshField> result;
    for (const std::string& name : order) add_field(of, name, scalars, result);
    of.mesh.fields = MeshFields(std::move(result));
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> read_fields<D>(Reader<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::cgns
