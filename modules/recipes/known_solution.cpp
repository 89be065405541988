module;
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.curving;
import camber.recovery;
import :known_solution;

namespace camber {

static_assert(lattice_degree == known_degree);

namespace {

template <int D>
Outcome<KnownSolution<D>> of_fields(const QuadraticMesh<D>& mesh, std::span<const WeightedField> fields,
                                    const QuadraticMesh<D>& curved, const Execution& execution) {
    std::vector<Column<double>> values;
    for (const WeightedField& field : fields) values.push_back(in_own_unit(field.values));
    auto known = element_values<D>(mesh, values, curved, execution);
    if (!known) return fail(known.error());
    KnownSolution<D> out;
    for (std::size_t f = 0; f < fields.size(); ++f)
        out.push_back({std::move((*known)[f]), fields[f].weight, own_exponent(fields[f].values)});
    return out;
}

template <int D>
Outcome<KnownSolution<D>> of_function(const QuadraticMesh<D>& mesh, const FunctionOfPlace<D>& function,
                                      const Execution& execution) {
    auto values = element_values(mesh, function, execution);
    if (!values) return fail(values.error());
    return KnownSolution<D>{{.values = std::move(values->rows), .exponent = values->exponent}};
}

}  // namespace

template <int D>
Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, const GivenSolution<D>& given,
                                         const QuadraticMesh<D>& curved, const Execution& execution) {
    return given.function ? of_function(curved, given.function, execution)
                          : of_fields<D>(mesh, given.fields, curved, execution);
}

template Outcome<KnownSolution<2>> known_solution<2>(const QuadraticMesh<2>&, const GivenSolution<2>&,
                                                     const QuadraticMesh<2>&, const Execution&);
template Outcome<KnownSolution<3>> known_solution<3>(const QuadraticMesh<3>&, const GivenSolution<3>&,
                                                     const QuadraticMesh<3>&, const Execution&);

}  // namespace camber
