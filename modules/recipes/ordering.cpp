module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.ordering;
import camber.io;
import camber.repair;

namespace camber::run {

namespace {

template <int D>
PlanSize size_of(const Mesh<D>& mesh) {
    const LinearMesh<D> m = straight_simplices(mesh);
    PlanSize size{D, mesh.degree, m.points.size(), m.elements.size(), m.facets.size(), mesh.entities.edges.size(), 0};
    size.peak_bytes = estimated_peak_bytes(size.vertices, size.elements, D);
    if (mesh.degree == 2) return size;
    // Euler: V − E + F − T = 1 with 2 F = 4 T + B in 3D; in 2D each triangle has three edges, inner ones shared.
    if (m.elements.size() == 0)
        size.edges = m.facets.size() * 3 / 2;
    else if (D == 3)
        size.edges = m.points.size() + m.elements.size() + m.facets.size() / 2;
    else
        size.edges = (3 * m.elements.size() + m.facets.size()) / 2;
    return size;
}

}  // namespace

PlanSize plan_size(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return size_of(m); }, mesh);
}

namespace {

bool changes_mesh(const config::Stage& stage) {
    return std::visit([]<class Options>(const Options&) { return changes_topology<Options>(); }, stage);
}

struct RowTag;
using RowId = Id<RowTag>;

class RowsBefore {
  public:
    template <class EntityId>
    void append(const Column<EntityId>& before) {
        const std::size_t begin = rows_.size();
        rows_.reserve(begin + before.size());
        for (const EntityId id : before) rows_.emplace_back(begin + id.index());
    }
    void append_unchanged(std::size_t count) {
        rows_.reserve(rows_.size() + count);
        for (std::size_t i = 0; i < count; ++i) rows_.emplace_back(rows_.size());
    }
    [[nodiscard]] Column<RowId> column() && { return std::move(rows_); }

  private:
    Buffer<RowId> rows_;
};

struct FieldRows {
    Column<RowId> nodes, cells;
};
template <int D>
FieldRows field_rows(const Mesh<D>& mesh, const Renumbering& back, const Column<EdgeId>& edges) {
    RowsBefore nodes, cells;
    nodes.append(back.vertices.before);
    nodes.append(edges);
    cells.append(back.elements.before);
    cells.append_unchanged(mesh.facets.template of<simplex<D - 1>>().size() + mesh.edges.size());
    return {std::move(nodes).column(), std::move(cells).column()};
}

template <int D>
Outcome<MeshFields> renumbered_fields(const MeshFields& fields, const FieldRows& before, const Execution& execution) {
    std::vector<MeshField> all(fields.begin(), fields.end());
    for (MeshField& field : all) {
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        auto values = std::visit(
            [&](const auto& rows) {
                return renumbered_rows(rows, field.centring == Centring::node ? before.nodes : before.cells, execution,
                                       width)
                    .map([](auto result) { return FieldValues(std::move(result)); });
            },
            field.values);
        if (!values) return fail(std::move(values.error()));
        field.values = std::move(*values);
    }
    return MeshFields(std::move(all));
}

Outcome<Done> renumber_rows(Solution& solution, const Column<VertexId>& before, const Execution& execution) {
    auto rows = renumbered_rows(solution.values, before, execution, row_width(solution));
    if (!rows) return fail(std::move(rows.error()));
    solution.values = std::move(*rows);
    return Done{};
}

/// Returns the original edges; none for degree 1.
template <int D>
Outcome<Column<EdgeId>> renumber(Mesh<D>& mesh, const Renumbering& order, const Execution& execution) {
    if (mesh.degree == 1) {
        auto result = renumbered(straight_simplices(std::move(mesh)), order, execution);
        if (!result) return fail(std::move(result.error()));
        mesh = as_mesh(std::move(*result));
        return Column<EdgeId>{};
    }
    auto quadratic = as_quadratic(std::move(mesh));
    if (!quadratic) return fail(std::move(quadratic.error()));
    auto result = renumbered(std::move(*quadratic), order, execution);
    if (!result) return fail(std::move(result.error()));
    mesh = as_mesh(std::move(result->mesh));
    return std::move(result->edges);
}

/// Original number (from 1) of an entity; 0 (none) is unchanged.
template <class EntityId>
std::size_t input_number(std::size_t number, const Permutation<EntityId>& order) {
    return number == 0 ? 0 : order.before[number - 1].index() + 1;
}

void renumber_report(Report& report, const Permutation<ElementId>& order, const Permutation<VertexId>& vertices) {
    for (auto* const validity : {&report.validity, &report.validity_before})
        if (*validity) (*validity)->worst = input_number((*validity)->worst, order);
    for (auto* const elements : {&report.invalid_elements, &report.undecided_elements, &report.elements_below_bound}) {
        for (std::size_t& e : *elements) e = input_number(e, order);
        std::ranges::sort(*elements);
    }
    for (RemainingReport& r : report.remaining) {
        r.element = input_number(r.element, order);
        r.at = input_number(r.at, vertices);
    }
    std::ranges::stable_sort(report.remaining, {}, &RemainingReport::element);
    if (!report.boundary) return;
    for (auto* const deviation : {&report.boundary->node_deviation, &report.boundary->vertex_deviation})
        if (*deviation)
            for (std::size_t& v : (*deviation)->vertices) v = input_number(v, vertices);
}

}  // namespace

template <int D>
Outcome<std::optional<BetterOrder>> working_order(const StageInputs<D>& inputs, std::span<const config::Stage> stages,
                                                  const OrderingOptions& options, const Execution& execution) {
    const auto has_mesh = [](const MetricFile& file) { return file.mesh.has_value(); };
    if (std::ranges::any_of(stages, changes_mesh) || std::ranges::any_of(inputs.files, has_mesh)) return std::nullopt;
    return better_order(straight_simplices(inputs.mesh), options, execution);
}

template <int D>
Outcome<StageInputs<D>> in_working_order(StageInputs<D> inputs, const Renumbering& order, const Execution& execution) {
    for (MetricFile& file : inputs.files)
        if (file.solution.rows == order.vertices.before.size())
            if (auto done = renumber_rows(file.solution, order.vertices.before, without_progress(execution)); !done)
                return fail(std::move(done.error()));
    auto done = renumber(inputs.mesh, order, execution);
    if (!done) return fail(std::move(done.error()));
    return inputs;
}

template <int D>
Outcome<MeshRun<D>> in_input_order(MeshRun<D> run, const Renumbering& order, const Execution& execution) {
    const Renumbering back = inverse(order);
    const auto edges = renumber(run.mesh, back, part_of(execution, 0, 0.9));
    if (!edges) return fail(edges.error());
    if (!run.fields.empty()) {
        auto fields = renumbered_fields<D>(run.fields, field_rows(run.mesh, back, *edges), part_of(execution, 0.9, 1));
        if (!fields) return fail(std::move(fields.error()));
        run.fields = std::move(*fields);
    }
    if (run.metric)
        if (auto done = renumber_rows(*run.metric, back.vertices.before, without_progress(execution)); !done)
            return fail(std::move(done.error()));
    renumber_report(run.report, order.elements, order.vertices);
    return run;
}

template <int D>
Error in_input_order(Error error, const Renumbering& order) {
    if (!error.entity) return error;
    auto& [kind, number] = *error.entity;
    if (kind.ends_with("vertex"))  // also "metric at vertex"
        number = input_number(number, order.vertices);
    else if (kind == simplex_name<D>)
        number = input_number(number, order.elements);
    return error;
}

std::string called(std::size_t place, std::uint64_t tag) {
    return tag == 0 ? fmt::format("{}", place) : fmt::format("{} (tag {})", place, tag);
}

std::string name_in(const Groups& groups, int dimension, Reference reference) {
    const auto found = std::ranges::find_if(
        groups, [&](const Group& g) { return g.dimension == dimension && g.reference == reference; });
    return found == groups.end() ? std::string() : found->name;
}

std::string called(const Groups& groups, int dimension, Reference reference) {
    const std::string name = name_in(groups, dimension, reference);
    return name.empty() ? fmt::format("{}", reference) : fmt::format("{} {}", reference, name);
}

FileNumbers numbers_of(const DecodedMesh& mesh) { return {mesh.node_numbers, mesh.tags}; }

Groups groups_of(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return Groups(m.groups.begin(), m.groups.end()); }, mesh);
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<std::optional<BetterOrder>> working_order<D>(                                              \
        const StageInputs<D>&, std::span<const config::Stage>, const OrderingOptions&, const Execution&);       \
    template Outcome<StageInputs<D>> in_working_order<D>(StageInputs<D>, const Renumbering&, const Execution&); \
    template Outcome<MeshRun<D>> in_input_order<D>(MeshRun<D>, const Renumbering&, const Execution&);           \
    template Error in_input_order<D>(Error, const Renumbering&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
