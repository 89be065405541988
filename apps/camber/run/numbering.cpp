module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.config;
import camber.io;
import camber.ordering;
import :numbering;
import :order;
import :pipeline;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

template <int D>
const LinearMesh<D>& straight_of(const LinearMesh<D>& mesh) {
    return mesh;
}
template <int D>
const LinearMesh<D>& straight_of(const QuadraticMesh<D>& mesh) {
    return mesh.linear;
}

bool changes_mesh(const config::Stage& stage) {
    return std::visit([]<class Options>(const Options&) { return changes_topology<Options>(); }, stage);
}

struct RowTag;
using RowId = Id<RowTag>;

/// Rows of several kinds of entities, one kind after the other: of each row the one that it was.
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

/// Of the rows of fields at nodes and at cells the ones that they were.
struct FieldRows {
    Column<RowId> nodes, cells;
};
template <int D>
FieldRows field_rows(const LinearMesh<D>& mesh, const Renumbering& back, const Column<EdgeId>& edges) {
    RowsBefore nodes, cells;
    nodes.append(back.vertices.before);
    nodes.append(edges);
    cells.append(back.elements.before);
    cells.append_unchanged(mesh.facets.size() + mesh.edges.size());
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
                    .map([](auto made) { return FieldValues(std::move(made)); });
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

/// Of a mesh that comes out the edges as they were; none in degree 1.
template <int D>
Outcome<Column<EdgeId>> renumber(LinearMesh<D>& mesh, const Renumbering& order, const Execution& execution) {
    auto made = renumbered(std::move(mesh), order, execution);
    if (!made) return fail(std::move(made.error()));
    mesh = std::move(*made);
    return Column<EdgeId>{};
}
template <int D>
Outcome<Column<EdgeId>> renumber(QuadraticMesh<D>& mesh, const Renumbering& order, const Execution& execution) {
    auto made = renumbered(std::move(mesh), order, execution);
    if (!made) return fail(std::move(made.error()));
    mesh = std::move(made->mesh);
    return std::move(made->edges);
}

/// An entity from 1 as it was; 0, which is none, stays.
template <class EntityId>
std::size_t given_number(std::size_t number, const Permutation<EntityId>& order) {
    return number == 0 ? 0 : order.before[number - 1].index() + 1;
}

void renumber_report(Report& report, const Permutation<ElementId>& order, const Permutation<VertexId>& vertices) {
    for (auto* const validity : {&report.validity, &report.validity_before})
        if (*validity) (*validity)->worst = given_number((*validity)->worst, order);
    for (auto* const elements : {&report.invalid_elements, &report.undecided_elements, &report.elements_below_bound}) {
        for (std::size_t& e : *elements) e = given_number(e, order);
        std::ranges::sort(*elements);
    }
    for (RemainingReport& r : report.remaining) {
        r.element = given_number(r.element, order);
        r.at = given_number(r.at, vertices);
    }
    std::ranges::stable_sort(report.remaining, {}, &RemainingReport::element);
    if (!report.boundary) return;
    for (auto* const deviation : {&report.boundary->node_deviation, &report.boundary->vertex_deviation})
        if (*deviation)
            for (std::size_t& v : (*deviation)->vertices) v = given_number(v, vertices);
}

}  // namespace

template <int D>
Outcome<std::optional<BetterOrder>> working_order(const StageInputs<D>& inputs, std::span<const config::Stage> stages,
                                                  const OrderingOptions& options, const Execution& execution) {
    const auto has_mesh = [](const MetricFile& file) { return file.mesh.has_value(); };
    if (std::ranges::any_of(stages, changes_mesh) || std::ranges::any_of(inputs.files, has_mesh)) return std::nullopt;
    return std::visit([&](const auto& m) { return better_order(straight_of(m), options, execution); }, inputs.mesh);
}

template <int D>
Outcome<StageInputs<D>> in_working_order(StageInputs<D> inputs, const Renumbering& order, const Execution& execution) {
    for (MetricFile& file : inputs.files)
        if (file.solution.rows == order.vertices.before.size())
            if (auto done = renumber_rows(file.solution, order.vertices.before, without_progress(execution)); !done)
                return fail(std::move(done.error()));
    auto done = std::visit([&](auto& mesh) { return renumber(mesh, order, execution); }, inputs.mesh);
    if (!done) return fail(std::move(done.error()));
    return inputs;
}

template <int D>
Outcome<Run> in_given_order(Run run, const Renumbering& order, const Execution& execution) {
    const Renumbering back = inverse(order);
    auto done = std::visit(
        [&]<class Mesh>(Mesh& mesh) -> Outcome<Done> {
            if constexpr (Mesh::dimension == D) {
                const auto edges = renumber(mesh, back, part_of(execution, 0, 0.9));
                if (!edges) return fail(edges.error());
                if (run.fields.empty()) return Done{};
                auto fields = renumbered_fields<D>(run.fields, field_rows(straight_of(mesh), back, *edges),
                                                   part_of(execution, 0.9, 1));
                if (!fields) return fail(std::move(fields.error()));
                run.fields = std::move(*fields);
            }
            return Done{};
        },
        run.mesh);
    if (!done) return fail(std::move(done.error()));
    if (run.metric)
        if (done = renumber_rows(*run.metric, back.vertices.before, without_progress(execution)); !done)
            return fail(std::move(done.error()));
    renumber_report(run.report, order.elements, order.vertices);
    return run;
}

template <int D>
Error in_given_order(Error error, const Renumbering& order) {
    if (!error.entity) return error;
    auto& [kind, number] = *error.entity;
    if (kind.ends_with("vertex"))  // "metric at vertex" too
        number = given_number(number, order.vertices);
    else if (kind == simplex_name<D>)
        number = given_number(number, order.elements);
    return error;
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<std::optional<BetterOrder>> working_order<D>(                                              \
        const StageInputs<D>&, std::span<const config::Stage>, const OrderingOptions&, const Execution&);       \
    template Outcome<StageInputs<D>> in_working_order<D>(StageInputs<D>, const Renumbering&, const Execution&); \
    template Outcome<Run> in_given_order<D>(Run, const Renumbering&, const Execution&);                         \
    template Error in_given_order<D>(Error, const Renumbering&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
