module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
module camber.recovery;
import camber.bezier;
import camber.core;

namespace camber {

namespace {

constexpr std::size_t elements_at_once = 64;

template <int D>
Outcome<Buffer<LatticeValues<D>>> sampled(const QuadraticMesh<D>& mesh, const FunctionOfPlace<D>& function,
                                          int exponent, const Execution& execution) {
    Buffer<LatticeValues<D>> values(mesh.linear.elements.size());
    const auto done = each_chunk(
        execution, values.size(),
        [&](std::size_t begin, std::size_t end) {
            const auto evaluate = function();
            std::array<double, node_count<lattice_degree, D>> u{};
            for (std::size_t e = begin; e < end; ++e) {
                const Lattice<D> places = lattice_of(mesh.linear, ElementId(e), edge_offsets(mesh, ElementId(e)));
                evaluate(std::span<const Vec<D>>(places), std::span<double>(u));
                for (std::size_t q = 0; q < u.size(); ++q)
                    values[e][q] = static_cast<float>(std::scalbn(u[q] - u[0], -exponent));
            }
        },
        elements_at_once);
    if (!done) return fail(done.error());
    return values;
}

}  // namespace

template <int D>
Outcome<FunctionValues<D>> element_values(const QuadraticMesh<D>& mesh, const FunctionOfPlace<D>& function,
                                          const Execution& execution) {
    return guarded([&]() -> Outcome<FunctionValues<D>> {
        if (mesh.linear.elements.size() == 0) return FunctionValues<D>{};
        Buffer<double> at_vertices(mesh.linear.points.size());
        function()(std::span<const Vec<D>>(mesh.linear.points), std::span<double>(at_vertices));
        const int exponent = own_exponent(at_vertices);
        auto values = sampled(mesh, function, exponent, execution);
        if (!values) return fail(values.error());
        const auto bad = std::ranges::find_if(*values, [](const LatticeValues<D>& at) {
            return !std::ranges::all_of(at, [](float x) { return std::isfinite(x); });
        });
        if (bad != values->end())
            return fail(ErrorKind::usage, "the function that nodes are placed by is no number there", {},
                        Entity{"element", static_cast<std::size_t>(bad - values->begin()) + 1},
                        "give one that is finite on the whole domain");
        return FunctionValues<D>{Column<LatticeValues<D>>(std::move(*values)), exponent};
    });
}

template Outcome<FunctionValues<2>> element_values<2>(const QuadraticMesh<2>&, const FunctionOfPlace<2>&,
                                                      const Execution&);
template Outcome<FunctionValues<3>> element_values<3>(const QuadraticMesh<3>&, const FunctionOfPlace<3>&,
                                                      const Execution&);

}  // namespace camber
