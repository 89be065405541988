module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.io;
import camber.metric;
import :fields;

namespace camber::run {

namespace {

template <int D>
bool positive_definite(const EigenSystem<D>& system) {
    return std::all_of(system.values.c.begin(), system.values.c.end(), [](double x) { return x > 0; });
}

/// Between two rows of a field: the log-Euclidean mean of metrics, the plain one of everything else.
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

/// The i-th field, whose columns in a row of the solution begin at `begin`; `edges`: their ends, or none in degree 1.
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
            {}, "give the fields of this mesh, one row a vertex");
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
Outcome<MeshFields> fields_on(const Solution& s, const std::string& name, const LinearMesh<D>& mesh,
                              const Execution& execution) {
    return fields_at<D>(s, name, mesh.points.size(), {}, execution);
}
template <int D>
Outcome<MeshFields> fields_on(const Solution& s, const std::string& name, const QuadraticMesh<D>& mesh,
                              const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size();
    if (s.rows == vertices + mesh.edges.size()) return fields_at<D>(s, name, s.rows, {}, execution);
    return fields_at<D>(s, name, vertices, mesh.edges.vertices, execution);
}

}  // namespace

Outcome<MeshFields> solution_fields(const Solution& solution, const std::string& name, const AnyMesh& mesh,
                                    const Execution& execution) {
    return std::visit([&](const auto& m) { return fields_on(solution, name, m, execution); }, mesh);
}

}  // namespace camber::run
