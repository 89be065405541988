module;
#include <array>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <vector>
export module camber.cad:in_plane;
import camber.core;
import camber.surface;
import :association;
import :model;

/// A model in a plane z = constant as the geometry of 2D meshes: its edges are the curves, at whichever height.
export namespace camber {

/// Errors (input): the model has no edges, or reaches out of a plane z = constant by more than 1e-7 of its size.
[[nodiscard]] Outcome<Done> check_flatness(const CadModel& model);

/// The model's edges, rising; of those that coincide (of faces that touch, each with its own) the first.
[[nodiscard]] std::vector<std::size_t> curves_of(const CadModel& model);

/// The point of an edge nearest to a point of the plane, and the unit normal there, to the right of the edge.
struct CadCurveFoot {
    Vec<2> point, normal;
    double t = 0, distance = 0;
};
/// As closest_on_edge: a point that lies there but for rounding stays as it is.
[[nodiscard]] CadCurveFoot closest_on_curve(const CadModel& model, std::size_t edge, const Vec<2>& p);
[[nodiscard]] EntityPoint<2> point_on_curve(const CadModel& model, std::size_t edge, double t);

/// The nearest of some edges, the lowest of equally near ones; nothing of none.
[[nodiscard]] std::optional<std::size_t> nearest_curve(const CadModel& model, std::span<const std::size_t> edges,
                                                       const Vec<2>& p);
/// As best_face; the misfit's last part is the length by the sine of the angle between the tangents.
[[nodiscard]] CadFit best_curve(const CadModel& model, std::span<const std::size_t> edges,
                                const std::array<Vec<2>, 2>& ends);

/// What facets can lie on: faces, in 2D curves; and the best of some.
template <int D>
[[nodiscard]] std::vector<std::size_t> candidates(const CadModel& model) {
    if constexpr (D == 2) return curves_of(model);
    std::vector<std::size_t> faces(model.faces());
    std::iota(faces.begin(), faces.end(), std::size_t{0});
    return faces;
}
template <int D>
[[nodiscard]] CadFit best_fit(const CadModel& model, std::span<const std::size_t> candidates,
                              const std::array<Vec<D>, D>& corners) {
    if constexpr (D == 2)
        return best_curve(model, candidates, corners);
    else
        return best_face(model, candidates, corners);
}

/// The end nearest to p at which edges around a point (rising, at least one) meet: any of two edges or more, of one
/// alone where it is closed with a kink. Nothing where there is none.
[[nodiscard]] std::optional<std::size_t> end_between(const CadModel& model, std::span<const std::size_t> edges,
                                                     const Vec<2>& p);
[[nodiscard]] Vec<2> vertex_in_plane(const CadModel& model, std::size_t vertex);

}  // namespace camber

namespace camber {

[[nodiscard]] inline Vec<2> in_plane(const Vec<3>& p) { return {{p[0], p[1]}}; }
[[nodiscard]] inline Box<2> in_plane(const Box<3>& box) {
    Box<2> out;
    out.low = in_plane(box.low);
    out.high = in_plane(box.high);
    return out;
}

}  // namespace camber
