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
Outcome<GivenSolution<D>> solution_on(const SolutionSource& source, const QuadraticMesh<D>& mesh,
                                      const Around& around) {
    const std::vector<double>& weights = source.weights;
    const auto check_weights = [&](std::size_t fields) -> Outcome<Done> {
        if (weights.empty() || weights.size() == fields) return Done{};
        return fail(ErrorKind::usage, fmt::format("there are {} weights, and {} fields", weights.size(), fields),
                    "/solution/weights", {}, "give one for each field, or none");
    };
    GivenSolution<D> out;
    if (!source.expression.empty()) {
        const auto parsed = ScalarExpression<D>::parsed(source.expression);
        if (!parsed) return fail(parsed.error());
        if (auto fit = check_weights(1); !fit) return fail(fit.error());
        out.function = [expression = *parsed] { return expression.evaluator(); };
        return out;
    }
    if (source.fields.empty()) return out;
    const auto brought = fields_brought_to(any_of(mesh), source.mesh, source.fields, TransferOptions{}, around);
    if (!brought) return fail(brought.error());
    const std::vector<NamedField>& fields = brought->fields;
    if (auto fit = check_weights(fields.size()); !fit) return fail(fit.error());
    for (std::size_t f = 0; f < fields.size(); ++f)
        for (Column<double>& scalar : scalars_of({&fields[f], 1}))
            out.fields.push_back({std::move(scalar), weights.empty() ? 1 : weights[f]});
    return out;
}

template Outcome<GivenSolution<2>> solution_on<2>(const SolutionSource&, const QuadraticMesh<2>&, const Around&);
template Outcome<GivenSolution<3>> solution_on<3>(const SolutionSource&, const QuadraticMesh<3>&, const Around&);

}  // namespace camber::run
