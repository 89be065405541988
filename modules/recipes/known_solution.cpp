module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.recipes;
import camber.bezier;
import camber.core;
import camber.curving;
import camber.recovery;
import :known_solution;
import :own_unit;

namespace camber {

static_assert(lattice_degree == known_degree);

namespace {

constexpr std::size_t elements_at_once = 64;

template <int D>
Outcome<KnownSolution<D>> of_fields(const QuadraticMesh<D>& mesh, std::span<const WeightedField> fields,
                                    const Execution& execution) {
    std::vector<Column<double>> values;
    for (const WeightedField& field : fields) values.push_back(in_own_unit(field.values));
    auto known = element_values<D>(mesh, values, execution);
    if (!known) return fail(known.error());
    KnownSolution<D> out;
    for (std::size_t f = 0; f < fields.size(); ++f) out.push_back({std::move((*known)[f]), fields[f].weight});
    return out;
}

template <int D>
using Lattice = std::array<Vec<D>, node_count<known_degree, D>>;

template <int D>
Lattice<D> lattice_of(const LinearMesh<D>& mesh, ElementId e) {
    Lattice<D> places{};
    for (std::size_t q = 0; q < places.size(); ++q)
        for (std::size_t v = 0; v <= D; ++v)
            places[q] += (multi_indices<known_degree, D>[q][v] * (1.0 / known_degree)) *
                         mesh.points[mesh.elements.vertices[e][v]];
    return places;
}

template <int D>
Outcome<KnownSolution<D>> of_function(const LinearMesh<D>& mesh, const FunctionOfPlace<D>& function,
                                      const Execution& execution) {
    if (mesh.points.empty()) return KnownSolution<D>{{.values = {}}};
    Buffer<double> at_vertices(mesh.points.size());
    function()(std::span<const Vec<D>>(mesh.points), std::span<double>(at_vertices));
    const int exponent = own_exponent(at_vertices);
    Buffer<std::array<float, node_count<known_degree, D>>> values(mesh.elements.size());
    const auto done = each_chunk(
        execution, mesh.elements.size(),
        [&](std::size_t begin, std::size_t end) {
            const auto evaluate = function();
            std::array<double, node_count<known_degree, D>> at{};
            for (std::size_t e = begin; e < end; ++e) {
                const Lattice<D> places = lattice_of(mesh, ElementId(e));
                evaluate(std::span<const Vec<D>>(places), std::span<double>(at));
                for (std::size_t q = 0; q < at.size(); ++q)
                    values[e][q] = static_cast<float>(std::scalbn(at[q] - at[0], -exponent));
            }
        },
        elements_at_once);
    if (!done) return fail(done.error());
    const auto bad = std::ranges::find_if(
        values, [](const auto& at) { return !std::ranges::all_of(at, [](float x) { return std::isfinite(x); }); });
    if (bad != values.end())
        return fail(ErrorKind::usage, "the function that nodes are placed by is no number there", {},
                    Entity{"element", static_cast<std::size_t>(bad - values.begin()) + 1},
                    "give one that is finite on the whole domain");
    return KnownSolution<D>{{.values = std::move(values)}};
}

}  // namespace

template <int D>
Outcome<KnownSolution<D>> known_solution(const QuadraticMesh<D>& mesh, const GivenSolution<D>& given,
                                         const Around& around) {
    return run_step(around, "recover", [&](const Execution& e) {
        return guarded([&] {
            return given.function ? of_function(mesh.linear, given.function, e) : of_fields<D>(mesh, given.fields, e);
        });
    });
}

template Outcome<KnownSolution<2>> known_solution<2>(const QuadraticMesh<2>&, const GivenSolution<2>&, const Around&);
template Outcome<KnownSolution<3>> known_solution<3>(const QuadraticMesh<3>&, const GivenSolution<3>&, const Around&);

}  // namespace camber
