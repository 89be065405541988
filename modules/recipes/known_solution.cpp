module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.curving;
import camber.recovery;
import :known_solution;
import :own_unit;

namespace camber {

namespace {

/// Of the vertices' values those of their rows.
Column<double> at_rows(const Column<double>& values, const MaterialRows& rows) {
    Buffer<double> out;
    out.reserve(rows.size());
    for (std::size_t v = 0; v < rows.vertices(); ++v)
        for (std::size_t i = 0; i < rows.materials[v].size(); ++i) out.push_back(values[v]);
    return Column<double>(std::move(out));
}

}  // namespace

template <int D>
Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, std::span<const WeightedField> fields,
                                         const Around& around) {
    std::vector<Column<double>> values;
    for (const WeightedField& field : fields) values.push_back(in_own_unit(field.values));
    auto derivatives = run_step(around, "recover", [&](const Execution& e) {
        return recover_derivatives<D>(mesh, values, RecoveryOptions{}, e);
    });
    if (!derivatives) return fail(derivatives.error());
    KnownSolution<D> out;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        FieldDerivatives<D>& d = derivatives->fields[f];
        out.fields.push_back({at_rows(values[f], derivatives->rows), std::move(d.gradients), std::move(d.hessians),
                              std::move(d.thirds), fields[f].weight});
    }
    Buffer<std::array<std::uint32_t, D + 1>> rows(mesh.linear.elements.size());
    for (std::size_t e = 0; e < rows.size(); ++e)
        for (int i = 0; i <= D; ++i)
            rows[e][static_cast<std::size_t>(i)] =
                static_cast<std::uint32_t>(row_of(derivatives->rows, mesh.linear, ElementId(e), i));
    out.rows = Column(std::move(rows));
    return out;
}

template Outcome<KnownSolution<2>> known_solution<2>(const QuadraticMesh<2>&, std::span<const WeightedField>,
                                                     const Around&);
template Outcome<KnownSolution<3>> known_solution<3>(const QuadraticMesh<3>&, std::span<const WeightedField>,
                                                     const Around&);

}  // namespace camber
