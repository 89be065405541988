module;
#include <array>
#include <cstddef>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.io;
import camber.recovery;
import :solution;

namespace camber::run {

namespace {

/// One a vertex, in the order of `Sym`.
template <int D>
Column<double> means_at_vertices(const RecoveredDerivatives<D>& recovered) {
    const MaterialRows& rows = recovered.rows;
    constexpr std::size_t width = Sym<D>{}.c.size();
    Buffer<double> values(rows.vertices() * width, 0.0);
    for (std::size_t v = 0; v < rows.vertices(); ++v) {
        const std::size_t first = rows.first(VertexId(v)), sides = rows.materials[VertexId(v)].size();
        for (std::size_t s = 0; s < sides; ++s)
            for (std::size_t k = 0; k < width; ++k)
                values[v * width + k] += recovered.fields[0].hessians[first + s].c[k] / static_cast<double>(sides);
    }
    return Column<double>(std::move(values));
}

}  // namespace

Outcome<Solution> hessians_of(const AnyMesh& mesh, const NamedField& field, const Execution& execution) {
    if (field.kind != FieldKind::scalar)
        return fail(ErrorKind::usage, "is no field of numbers", field.name, {}, "give one component");
    return std::visit(
        [&]<class Mesh>(const Mesh&) -> Outcome<Solution> {
            constexpr int D = Mesh::dimension;
            const auto quadratic = of_degree_2<D>(mesh, without_progress(execution));
            if (!quadratic) return fail(quadratic.error());
            const std::array<Column<double>, 1> values{field.field.values};
            const auto recovered = recover_derivatives<D>(*quadratic, values, {}, execution);
            if (!recovered) return fail(recovered.error());
            return Solution{
                D, {FieldKind::symmetric_tensor}, recovered->rows.vertices(), means_at_vertices(*recovered)};
        },
        mesh);
}

}  // namespace camber::run
