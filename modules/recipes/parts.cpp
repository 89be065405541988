module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.optimisation;
import camber.io;
import camber.surface;
import camber.curving;
import camber.operation;
import camber.repair;

namespace camber::run {

namespace {

void add_up(std::optional<RelaxReport>& sum, const RelaxReport& part) {
    if (!sum) sum.emplace();
    sum->method = part.method;
    sum->corrected_elements += part.corrected_elements;
    sum->raised_elements += part.raised_elements;
    sum->relaxed_volume_edges += part.relaxed_volume_edges;
    sum->relaxed_surface_edges += part.relaxed_surface_edges;
    sum->slid_surface_edges += part.slid_surface_edges;
    sum->slid_vertices += part.slid_vertices;
    sum->moved_vertices += part.moved_vertices;
    sum->work += part.work;
    sum->unresolved += part.unresolved;
}

}  // namespace

std::vector<std::pair<std::string, std::size_t>> PassReport::rejected_by_reason() const {
    std::vector<std::pair<std::string, std::size_t>> counts;
    for (const auto& reason : words(RejectionReason{}))
        if (const std::size_t n = of(reason.value); n > 0 && reason.value != RejectionReason::none)
            counts.emplace_back(reason.word, n);
    return counts;
}

RelaxReport relax_report(const RepairStatistics& s, std::size_t unresolved, RepairMethod method) {
    return {.method = std::string(word_of(method)),
            .corrected_elements = s.corrected_elements,
            .raised_elements = s.raised_elements,
            .relaxed_volume_edges = s.moved_volume_nodes,
            .relaxed_surface_edges = s.moved_surface_nodes,
            .moved_vertices = s.moved_vertices,
            .work = s.work,
            .unresolved = unresolved};
}

template <int D>
VerdictsReport verdicts_report(const Validation<D>& v, bool is_explicit) {
    VerdictsReport part;
    auto next = v.not_positive.begin();
    for (std::size_t e = 0; e < v.verdicts.size(); ++e) {
        if (next != v.not_positive.end() && next->first == ElementId(e))
            (next++->second == Verdict::invalid ? part.invalid : part.undecided).push_back(e + 1);
        else if (v.verdicts[e] != Verdict::valid)
            part.below_bound.push_back(e + 1);
    }
    part.summary = {v.bound,
                    is_explicit,
                    part.invalid.size(),
                    part.undecided.size(),
                    part.below_bound.size(),
                    v.straight_inverted,
                    v.smallest,
                    v.worst.valid() ? v.worst.index() + 1 : 0};
    return part;
}

void add(Report& report, const BoundaryReport& part) {
    report.boundary = part;
    if (part.cad && !part.cad->within_materials.empty())
        report.notices.push_back(fmt::format(
            "reference{} {}: the facets lie within one material and not on the CAD model; they have no CAD "
            "geometry",
            part.cad->within_materials.size() == 1 ? "" : "s", fmt::join(part.cad->within_materials, ", ")));
    if (!part.off_surfaces || part.off_surfaces->vertices == 0) return;
    const OffSurfacesReport& off = *part.off_surfaces;
    report.notices.push_back(fmt::format(
        "{} {} not on the analytic surface of their reference, by up to {:.4g}: they are not moved, and adjacent nodes "
        "are placed on the surface",
        off.vertices, off.vertices == 1 ? "vertex is" : "vertices are", off.largest));
}

void add(Report& report, VerdictsReport part) {
    report.validity = part.summary;
    report.invalid_elements = std::move(part.invalid);
    report.undecided_elements = std::move(part.undecided);
    report.elements_below_bound = std::move(part.below_bound);
}

void add(Report& report, const CorrectionReport& part) {
    add_up(report.relax, part.relax);
    if (part.input_boundary) report.input_boundary = part.input_boundary;
    report.remaining = part.remaining;
}

void add(Report& report, const PassReport& part) {
    auto& passes = report.remesh->passes;
    const auto same = std::ranges::find(passes, part.pass, &PassReport::pass);
    if (same == passes.end())
        passes.push_back(part);
    else
        static_cast<PassStatistics&>(*same) += part;
}

void add(std::vector<Histogram>& all, std::vector<Histogram> part) { std::ranges::move(part, std::back_inserter(all)); }

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Field with one value per edge. A vertex has the mean of its edges for which `counts` is true.
template <int D>
MeshField edge_field_with_means(const QuadraticMesh<D>& mesh, std::string name, std::span<const double> values,
                                const auto& counts) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<double> column(vertices + values.size());
    std::fill(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(vertices), 0.0);
    std::vector<std::uint32_t> around(vertices);
    for (std::size_t e = 0; e < values.size(); ++e) {
        column[vertices + e] = values[e];
        if (!counts(e)) continue;
        for (const VertexId v : mesh.edges.vertices[e]) {
            column[v.index()] += values[e];
            ++around[v.index()];
        }
    }
    for (std::size_t v = 0; v < vertices; ++v)
        if (around[v] > 0) column[v] /= around[v];
    return {std::move(name), Centring::node, FieldKind::scalar, Column<double>(std::move(column))};
}

template <int D>
MeshField edge_changes(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    const std::size_t vertices = mesh.linear.points.size();
    Buffer<std::int32_t> column(vertices + mesh.edges.size());
    for (std::size_t n = 0; n < column.size(); ++n)
        column[n] = n < vertices ? -1 : static_cast<std::int32_t>(proposal.changes[n - vertices]);
    return {"edge_change", Centring::node, FieldKind::scalar, Column<std::int32_t>(std::move(column))};
}

template <int D>
double distance_from(const Geometry<D>& geometry, const LinearMesh<D>& mesh, std::span<const FacetId> facets,
                     const Vec<D>& p) {
    return facets.empty() ? nan : geometry->distance_at_facets(facet_sites(mesh, facets), p);
}

template <int D>
Outcome<MeshField> distances(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    auto at_vertices = facet_balls(mesh.linear, quiet);
    if (!at_vertices) return fail(std::move(at_vertices.error()));
    auto at_edges = facet_shells(mesh.edges, quiet);
    if (!at_edges) return fail(std::move(at_edges.error()));
    const std::size_t vertices = mesh.linear.points.size();
    auto column = map_each(
        execution, vertices + mesh.edges.size(),
        [&](std::size_t n) {
            const bool vertex = n < vertices;
            return distance_from(geometry, mesh.linear, vertex ? (*at_vertices)[n] : (*at_edges)[n - vertices],
                                 vertex ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point);
        },
        64);
    if (!column) return fail(std::move(column.error()));
    return MeshField{"distance_to_geometry", Centring::node, FieldKind::scalar, Column<double>(std::move(*column))};
}

template <int D>
Outcome<MeshField> metrics(const QuadraticMesh<D>& mesh, const BackMesh<D>& back, const Incidence<ElementId>& shells,
                           const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size();
    const auto log_at = [&](std::size_t n) -> LogMetric<D> {
        if (n < vertices) return back->vertex(VertexId(n)).log_metric;
        const std::size_t e = n - vertices;
        const auto& [a, b] = mesh.edges.vertices[e];
        // The metric of an edge without elements is the mean of its ends.
        return shells[e].empty() ? LogMetric<D>{0.5 * (back->vertex(a).log_metric.l + back->vertex(b).log_metric.l)}
                                 : sample_value(back, mesh.mid_nodes[e].point, shells[e][0]).log_metric;
    };
    return tensor_rows<D>(vertices + mesh.edges.size(), log_at, execution).map([](Column<double> column) {
        return MeshField{"metric", Centring::node, FieldKind::symmetric_tensor, std::move(column)};
    });
}

}  // namespace

template <int D>
Outcome<MeshFields> mesh_fields(const Quadratic<D>& end, const BackMesh<D>* field,
                                const std::optional<EdgeLengths>& lengths, const Execution& execution) {
    const QuadraticMesh<D>& mesh = end.mesh;
    const Plan<D>* const plan = end.planned();
    MeshFields fields;
    if (const Validation<D>* validation = end.validation())
        fields = std::move(fields)
                     .with(cell_field(mesh.linear, "scaled_jacobian", 0, validation->min_scaled_jacobian, nan))
                     .with(cell_field(mesh.linear, "verdict", 0, validation->verdicts, std::int32_t{-1}));
    if (plan) fields = std::move(fields).with(node_kinds(mesh, plan->features()));
    fields = std::move(fields).with(edge_field_with_means(mesh, "curvature", curvatures<D>(mesh, mesh.mid_nodes.view()),
                                                          [](std::size_t) { return true; }));
    if (plan) fields = std::move(fields).with(edge_changes(mesh, plan->proposal()));
    if (plan && lengths && !is_standalone_surface(mesh.linear))
        fields = std::move(fields).with(
            edge_field_with_means(mesh, "length_reduction", length_reductions(lengths->straight, lengths->curved),
                                  [&](std::size_t e) { return plan->proposal().kinds[e] == EdgeKind::volume; }));
    const CurvingTarget<D>* const target = plan ? plan->target() : nullptr;
    if (target) {
        auto result = distances(mesh, target->boundary.geometry, part_of(execution, 0, 0.1));
        if (!result) return fail(std::move(result.error()));
        fields = std::move(fields).with(std::move(*result));
    }
    if (target && field) {
        auto result = metrics(mesh, *field, target->shells, part_of(execution, 0.1, 1));
        if (!result) return fail(std::move(result.error()));
        fields = std::move(fields).with(std::move(*result));
    }
    return fields;
}

template <int D>
Outcome<Solution> metric_solution(const Column<LogMetric<D>>& log_metrics, const Execution& execution) {
    const std::size_t rows = log_metrics.size();
    return tensor_rows<D>(
               rows, [&](std::size_t n) { return log_metrics[n]; }, execution)
        .map(
            [&](Column<double> values) { return Solution{D, {FieldKind::symmetric_tensor}, rows, std::move(values)}; });
}

template <int D>
Outcome<Solution> metric_solution(const BackMesh<D>& field, const Execution& execution) {
    auto logs = map_each(execution, field->vertex_count(),
                         [&](std::size_t v) { return field->vertex(VertexId(v)).log_metric; });
    if (!logs) return fail(std::move(logs.error()));
    return metric_solution<D>(Column<LogMetric<D>>(std::move(*logs)), execution);
}

template <int D>
Outcome<Solution> metric_solution(const BackMesh<D>& field, const QuadraticMesh<D>& mesh, const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size();
    const auto node = [&](std::size_t n) {
        return n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point;
    };
    return sampled_logs(field, vertices + mesh.edges.size(), node, execution).and_then([&](const auto& logs) {
        return metric_solution<D>(logs, execution);
    });
}

namespace {

template <int D>
bool positive_definite(const EigenSystem<D>& system) {
    return std::all_of(system.values.c.begin(), system.values.c.end(), [](double x) { return x > 0; });
}

template <int D>
void mean_row(FieldKind kind, const double* a, const double* b, double* to) {
    const auto width = static_cast<std::size_t>(values_per_vertex(kind, D));
    for (std::size_t c = 0; c < width; ++c) to[c] = 0.5 * (a[c] + b[c]);
    if (kind != FieldKind::symmetric_tensor) return;
    Metric<D> low, high;
    std::copy(a, a + width, low.m.c.begin());
    std::copy(b, b + width, high.m.c.begin());
    if (!positive_definite(eigen_system(low.m)) || !positive_definite(eigen_system(high.m))) return;
    const Sym<D> mean = exp(LogMetric<D>{0.5 * (log(low).l + log(high).l)}).m;
    std::copy(mean.c.begin(), mean.c.end(), to);
}

std::string field_name(const Solution& solution, std::size_t i) {
    if (solution.fields.size() == 1 && solution.fields[0] == FieldKind::symmetric_tensor) return "metric";
    if (solution.fields.size() == 1 && solution.fields[0] == FieldKind::scalar) return "size";
    return "field_" + std::to_string(i + 1);
}

/// The i-th field. `begin`: its first column in a row; `edges`: ends of the edges, empty for degree 1.
template <int D>
Outcome<MeshField> one_field(const Solution& solution, std::size_t i, std::size_t begin,
                             const Column<std::array<VertexId, 2>>& edges, const Execution& execution) {
    const FieldKind kind = solution.fields[i];
    const auto width = static_cast<std::size_t>(values_per_vertex(kind, D));
    const std::size_t stride = row_width(solution), vertices = solution.rows;
    Buffer<double> column((vertices + edges.size()) * width);
    const auto row = [&](std::size_t v) { return solution.values.data() + v * stride + begin; };
    auto done = each(execution, vertices + edges.size(), [&](std::size_t n) {
        double* const to = column.data() + n * width;
        if (n < vertices)
            std::copy(row(n), row(n) + width, to);
        else
            mean_row<D>(kind, row(edges[n - vertices][0].index()), row(edges[n - vertices][1].index()), to);
    });
    if (!done) return fail(std::move(done.error()));
    return MeshField{field_name(solution, i), Centring::node, kind, Column<double>(std::move(column))};
}

template <int D>
Outcome<MeshFields> fields_at(const Solution& solution, const std::string& name, std::size_t vertices,
                              const Column<std::array<VertexId, 2>>& edges, const Execution& execution) {
    if (solution.dimension != D)
        return fail(ErrorKind::input,
                    "is in " + std::to_string(solution.dimension) + "D, the mesh in " + std::to_string(D) + "D", name,
                    {}, "give the fields of this mesh");
    if (solution.rows != vertices)
        return fail(
            ErrorKind::input,
            "has " + std::to_string(solution.rows) + " rows, the mesh " + std::to_string(vertices) + " vertices", name,
            {}, "give the fields of this mesh, one row per vertex");
    MeshFields fields;
    std::size_t begin = 0;
    for (std::size_t i = 0; i < solution.fields.size(); ++i) {
        auto field = one_field<D>(solution, i, begin, edges, execution);
        if (!field) return fail(std::move(field.error()));
        fields = std::move(fields).with(std::move(*field));
        begin += static_cast<std::size_t>(values_per_vertex(solution.fields[i], D));
    }
    return fields;
}

template <int D>
Outcome<MeshFields> fields_on(const Solution& s, const std::string& name, const Mesh<D>& mesh,
                              const Execution& execution) {
    if (s.rows == count_nodes(mesh)) return fields_at<D>(s, name, s.rows, {}, execution);
    return fields_at<D>(s, name, mesh.points.size(), mesh.entities.edges, execution);
}

}  // namespace

Outcome<MeshFields> solution_fields(const Solution& solution, const std::string& name, const AnyMesh& mesh,
                                    const Execution& execution) {
    return std::visit([&](const auto& m) { return fields_on(solution, name, m, execution); }, mesh);
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template VerdictsReport verdicts_report<D>(const Validation<D>&, bool);                                       \
    template Outcome<Solution> metric_solution<D>(const BackMesh<D>&, const QuadraticMesh<D>&, const Execution&); \
    template Outcome<Solution> metric_solution<D>(const BackMesh<D>&, const Execution&);                          \
    template Outcome<Solution> metric_solution<D>(const Column<LogMetric<D>>&, const Execution&);                 \
    template Outcome<MeshFields> mesh_fields<D>(const Quadratic<D>&, const BackMesh<D>*,                          \
                                                const std::optional<EdgeLengths>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
