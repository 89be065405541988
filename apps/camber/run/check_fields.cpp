module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.io;
import camber.validity;
import :check;
import :element_measures;

namespace camber::run {

namespace {

/// Cells that are judged, and all of them.
struct CellCounts {
    std::size_t judged = 0, cells = 0;
};

/// What elements have, and `none` on the other cells. Elements come first, of a surface alone facets do.
template <class T>
MeshField at_cells(std::string name, const CellCounts& size, T none, auto&& value) {
    Buffer<T> values(size.cells);
    std::fill(values.begin(), values.end(), none);
    for (std::size_t e = 0; e < size.judged; ++e) values[e] = static_cast<T>(value(e));
    return {std::move(name), Centring::cell, FieldKind::scalar, Column<T>(std::move(values))};
}

template <int D>
Outcome<MeshFields> fields_of(const LinearMesh<D>& mesh, const CheckReport& report, const Execution& execution) {
    const CellCounts size{judged_count(mesh), mesh.elements.size() + mesh.facets.size() + mesh.edges.size()};
    const ElementColumns& columns = report.elements;
    auto qualities = map_each(execution, size.judged, [&](std::size_t e) { return quality_of(mesh, e); });
    if (!qualities) return fail(qualities.error());
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<MeshField> fields{
        at_cells<std::int32_t>("verdict", size, -1, [&](std::size_t e) { return columns.verdicts[e]; }),
        at_cells<double>("quality", size, nan, [&](std::size_t e) { return (*qualities)[e]; })};
    if (!columns.min_scaled_jacobian.empty())
        fields.push_back(at_cells<double>("scaled_jacobian", size, nan,
                                          [&](std::size_t e) { return columns.min_scaled_jacobian[e]; }));
    return MeshFields(std::move(fields));
}

}  // namespace

Outcome<MeshFields> check_fields(const AnyMesh& mesh, const CheckReport& report, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh& m) {
            if constexpr (std::is_same_v<Mesh, LinearMesh<Mesh::dimension>>)
                return fields_of(m, report, execution);
            else
                return fields_of(m.linear, report, execution);
        },
        mesh);
}

}  // namespace camber::run
