module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.bezier;
import camber.fields;
import camber.io;
import camber.recipes;
import camber.transfer;
import :solution;
import :solution_source;

namespace camber::run {

namespace {

template <int D>
Outcome<NamedField> evaluated(const QuadraticMesh<D>& mesh, const std::string& text, const Execution& execution) {
    const auto parsed = ScalarExpression<D>::parsed(text);
    if (!parsed) return fail(parsed.error());
    Buffer<Vec<D>> nodes(mesh.linear.points.begin(), mesh.linear.points.end());
    nodes.reserve(nodes.size() + mesh.edges.size());
    for (const LagrangeNode<D>& node : mesh.mid_nodes) nodes.push_back(node.point);
    Buffer<double> values(nodes.size());
    const auto done = each_chunk(
        execution, nodes.size(),
        [&](std::size_t begin, std::size_t end) {
            parsed->evaluator()(std::span(nodes).subspan(begin, end - begin),
                                std::span(values).subspan(begin, end - begin));
        },
        4096);
    if (!done) return fail(done.error());
    if (!std::ranges::all_of(values, [](double x) { return std::isfinite(x); }))
        return fail(ErrorKind::usage, "is no number at a node of the mesh", quoted_expression(text), {},
                    "give one that is finite on the whole domain");
    return NamedField{"expression", FieldKind::scalar, {1, 2, Column<double>(std::move(values))}};
}

template <int D>
AnyMesh any_of(const QuadraticMesh<D>& mesh) {
    return mesh;
}

}  // namespace

Outcome<NamedField> field_of_expression(const AnyMesh& mesh, const std::string& expression,
                                        const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh&) -> Outcome<NamedField> {
            const auto quadratic = of_degree_2<Mesh::dimension>(mesh, without_progress(execution));
            if (!quadratic) return fail(quadratic.error());
            return evaluated(*quadratic, expression, execution);
        },
        mesh);
}

template <int D>
Outcome<std::vector<WeightedField>> fields_on(const SolutionSource& source, const QuadraticMesh<D>& mesh,
                                              const Around& around) {
    std::vector<NamedField> fields;
    if (!source.expression.empty()) {
        auto made =
            run_step(around, "transfer", [&](const Execution& e) { return evaluated(mesh, source.expression, e); });
        if (!made) return fail(made.error());
        fields.push_back(std::move(*made));
    } else if (!source.fields.empty()) {
        auto brought = fields_brought_to(any_of(mesh), source.mesh, source.fields, TransferOptions{}, around);
        if (!brought) return fail(brought.error());
        fields = std::move(brought->fields);
    }
    const std::vector<double>& weights = source.weights;
    if (!weights.empty() && weights.size() != fields.size())
        return fail(ErrorKind::usage, fmt::format("there are {} weights, and {} fields", weights.size(), fields.size()),
                    "/solution/weights", {}, "give one for each field, or none");
    std::vector<WeightedField> out;
    for (std::size_t f = 0; f < fields.size(); ++f)
        for (Column<double>& scalar : scalars_of({&fields[f], 1}))
            out.push_back({std::move(scalar), weights.empty() ? 1 : weights[f]});
    return out;
}

template Outcome<std::vector<WeightedField>> fields_on<2>(const SolutionSource&, const QuadraticMesh<2>&,
                                                          const Around&);
template Outcome<std::vector<WeightedField>> fields_on<3>(const SolutionSource&, const QuadraticMesh<3>&,
                                                          const Around&);

}  // namespace camber::run
