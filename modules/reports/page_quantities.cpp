module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.drawing;
import camber.metric;
import camber.soundness;
import camber.io;

namespace camber::run {

namespace {

constexpr double largest_drawn = 1e30;  // drawn values must be finite

std::array<double, 2> range_of(std::span<const float> values, bool positive) {
    std::array<double, 2> range{largest_drawn, -largest_drawn};
    for (const float v : values)
        if (std::isfinite(v) && std::abs(v) < largest_drawn && (!positive || v > 0)) {
            range[0] = std::min<double>(range[0], v);
            range[1] = std::max<double>(range[1], v);
        }
    return range[0] <= range[1] ? range : std::array<double, 2>{0, 1};
}

void clamp_to_drawn(std::vector<float>& values) {
    for (float& v : values)
        if (!std::isnan(v)) v = std::clamp(v, -static_cast<float>(largest_drawn), static_cast<float>(largest_drawn));
}

void add(PageQuantities& all, PageQuantity quantity, std::vector<float> values) {
    clamp_to_drawn(values);
    quantity.range = range_of(values, quantity.scale == ValueScale::log);
    all.arrays.push_back(array_of_rounded(quantity.key, values));
    all.quantities.push_back(std::move(quantity));
}

void add_references(PageQuantities& all, PageQuantity quantity, const std::vector<std::int32_t>& references,
                    const Column<Group>& groups, int dimension) {
    std::map<Reference, std::string> there;
    for (const Reference r : references) there[r];
    if (there.size() < 2) return;
    for (const Group& group : groups)
        if (group.dimension == dimension && there.contains(group.reference)) there[group.reference] = group.name;
    quantity.scale = ValueScale::categories;
    quantity.categories.assign(there.begin(), there.end());
    all.arrays.push_back(array_of_integers(quantity.key, references));
    all.quantities.push_back(std::move(quantity));
}

template <int D>
std::vector<float> of_elements(const PageMesh<D>& page, auto&& value) {
    std::vector<float> values;
    values.reserve(page.elements.size());
    for (const std::uint32_t e : page.elements) values.push_back(static_cast<float>(value(e)));
    return values;
}

template <int D>
std::vector<double> row_at(const PageMesh<D>& page, const NamedField& field, NodeNumber n) {
    const auto width = static_cast<std::size_t>(field.field.components);
    const std::size_t vertices = page.mesh->points.size();
    const double* values = field.field.values.data();
    if (n < vertices || field.field.degree == 2) return {values + n * width, values + (n + 1) * width};
    const auto& [a, b] = page.mesh->entities.edges[n - vertices];
    std::vector<double> row(width);
    for (std::size_t c = 0; c < width; ++c)
        row[c] = 0.5 * (values[a.index() * width + c] + values[b.index() * width + c]);
    return row;
}

/// Ratio of the largest and smallest size of a metric.
template <int D>
double anisotropy(std::span<const double> row) {
    Sym<D> m;
    std::copy_n(row.begin(), sym_size<D>, m.c.begin());
    const Vec<D> values = eigen_system(m).values;
    double least = values[0], largest = values[0];
    for (int i = 1; i < D; ++i) {
        least = std::min(least, values[i]);
        largest = std::max(largest, values[i]);
    }
    return least > 0 ? std::sqrt(largest / least) : std::numeric_limits<double>::quiet_NaN();
}

/// Displayed number of a row: the value, a vector's length, or a tensor's anisotropy.
template <int D>
double shown(FieldKind kind, const std::vector<double>& row) {
    if (kind == FieldKind::symmetric_tensor) return anisotropy<D>(row);
    if (row.size() == 1) return row[0];
    double squares = 0;
    for (const double x : row) squares += x * x;
    return std::sqrt(squares);
}

std::string title_of(const NamedField& field) {
    if (field.kind == FieldKind::symmetric_tensor)
        return field.name == "metric" ? "Anisotropy of the metric" : "Anisotropy of " + field.name;
    return field.field.components > 1 ? "Length of " + field.name : field.name;
}

template <int D>
void add_field(PageQuantities& all, const PageMesh<D>& page, const NamedField& field, std::size_t number) {
    std::vector<float> values;
    values.reserve(page.nodes.size());
    for (const NodeNumber n : page.nodes)
        values.push_back(static_cast<float>(shown<D>(field.kind, row_at(page, field, n))));
    PageQuantity quantity{.key = "field-" + std::to_string(number), .title = title_of(field), .on = ValuesOn::nodes};
    if (field.kind == FieldKind::symmetric_tensor) quantity.scale = ValueScale::log;
    add(all, std::move(quantity), std::move(values));
}

}  // namespace

template <int D>
PageQuantities page_quantities(const PageMesh<D>& page, const PageSource& source) {
    PageQuantities all;
    const ElementColumns& columns = source.report.elements;
    const LinearMesh<D> linear = straight_simplices(*page.mesh);
    const std::array<double, 2> whole{0, 1};
    if (!columns.min_scaled_jacobian.empty())
        add(all,
            {.key = "scaled-jacobian", .title = "Scaled Jacobian", .good_is_high = true, .whole = whole, .bad = 0.0},
            of_elements(page, [&](std::uint32_t e) { return columns.min_scaled_jacobian[e]; }));
    add(all,
        {.key = "quality",
         .title = "Quality of the straight element",
         .good_is_high = true,
         .whole = whole,
         .bad = 0.0},
        of_elements(page, [&](std::uint32_t e) { return quality_of(linear, e); }));
    for (std::size_t i = 0; i < source.fields.size(); ++i) add_field(all, page, source.fields[i], i + 1);
    const int dimension = is_standalone_surface(linear) ? 2 : D;
    std::vector<std::int32_t> references;
    references.reserve(std::max(page.elements.size(), page.outer.size()));
    for (const std::uint32_t e : page.elements) references.push_back(columns.references[e]);
    add_references(all, {.key = "reference", .title = "Reference of elements"}, references, linear.groups, dimension);
    if (D == 3 && !is_standalone_surface(linear)) {
        references.clear();
        for (const Face& face : page.outer) references.push_back(face.reference);
        add_references(all, {.key = "boundary-reference", .title = "Reference of the boundary", .on = ValuesOn::faces},
                       references, linear.groups, 2);
    }
    return all;
}

template PageQuantities page_quantities<2>(const PageMesh<2>&, const PageSource&);
template PageQuantities page_quantities<3>(const PageMesh<3>&, const PageSource&);

}  // namespace camber::run
