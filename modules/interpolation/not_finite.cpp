module;
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <sstream>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
Error find_not_finite(const QuadraticMesh<D>& mesh, std::size_t e, Sides sides, const Rules<D>& rules,
                      Integrator<D>& integrator) {
    const Entity element{simplex_name<D>, e + 1U};
    constexpr const char* remedy = "it must be finite wherever the mesh is";
    const auto look = [&](std::span<const Vec<D>> points, std::span<const double> values) -> std::optional<Error> {
        for (std::size_t p = 0; p < points.size(); ++p) {
            if (std::isfinite(values[p])) continue;
            std::ostringstream text;
            text.precision(10);
            text << "the field is " << values[p] << " at ";
            for (int c = 0; c < D; ++c) text << (c > 0 ? ", " : "(") << points[p][c];
            text << ')';
            return Error{ErrorKind::usage, text.str(), {}, element, remedy};
        }
        return {};
    };
    const auto nodes = nodes_of(mesh, e, sides);
    std::array<double, quadratic_nodes<D>> u{};
    integrator.evaluate(nodes, u);
    if (auto found = look(nodes, u)) return *found;
    for (const CollapsedRule<D>& rule : rules) {
        static_cast<void>(integrator.integrate(piece_of(mesh, e, sides, {}, integrator), rule));
        if (auto found = look(integrator.points(), integrator.values())) return *found;
    }
    return Error{
        ErrorKind::usage, "the field or its error's square is beyond the range of numbers", {}, element, remedy};
}

#define CAMBER_INSTANTIATE(D) \
    template Error find_not_finite<D>(const QuadraticMesh<D>&, std::size_t, Sides, const Rules<D>&, Integrator<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
