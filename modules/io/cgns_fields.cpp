module;
#include "cgns_library.hpp"

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :cgns_reader;

/// Solutions of the flow.
namespace camber::cgns {

namespace {

/// The scalar, or with its first component the vector that it belongs to.
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
    // A field of several zones would have to be of all of them.
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
                                  in_quotes(name.data()) + " are not at all vertices and were skipped"});
            continue;
        }
        for (int f = 1; f <= fields; ++f) {
            CGNS_ENUMT(DataType_t) type{};
            Name field{};
            if (auto bearable = of.announced(of.mesh.points.size(), "field " + std::to_string(f)); !bearable)
                return bearable;
            Buffer<double> values(of.mesh.points.size());
            const cgsize_t first = 1, last = static_cast<cgsize_t>(of.mesh.points.size());
            if (of.lib.field_info_(of.file, 1, of.zone, s, f, &type, field.data()) != CG_OK ||
                of.lib.field_read_(of.file, 1, of.zone, s, field.data(), CGNS_ENUMV(RealDouble), &first, &last,
                                   values.data()) != CG_OK)
                return of.broken("field " + std::to_string(f) + " cannot be read");
            if (type != CGNS_ENUMV(RealDouble) && type != CGNS_ENUMV(RealSingle) && type != CGNS_ENUMV(Integer) &&
                type != CGNS_ENUMV(LongInteger)) {
                of.notices.push_back({"the field " + in_quotes(field.data()) + " is not of real numbers: left out"});
                continue;
            }
            if (scalars.contains(field.data()))
                of.notices.push_back(
                    {"the field " + in_quotes(field.data()) + " is in several solutions: the last was taken"});
            else
                order.emplace_back(field.data());
            scalars.insert_or_assign(field.data(), Column<double>(std::move(values)));
        }
    }
    std::vector<MeshField> made;
    for (const std::string& name : order) add_field(of, name, scalars, made);
    of.mesh.fields = MeshFields(std::move(made));
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> read_fields<D>(Reader<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::cgns
