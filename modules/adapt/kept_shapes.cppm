module;
#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
module camber.adapt:kept_shapes;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

/// The state comes to know the shape of each element, measured where it does not yet.
template <int D>
[[nodiscard]] Outcome<Done> know_shapes(Adaptation<D>& r, const Execution& execution) {
    auto shapes = take(std::move(r.shapes));
    shapes.resize(r.mesh.elements.size(), -1.0);
    auto measured = each(execution, shapes.size(), [&](std::size_t e) {
        if (!r.mesh.is_free(ElementId(e)) && shapes[e] < 0) shapes[e] = shape_of(r, ElementId(e));
    });
    r.shapes = std::move(shapes);
    return measured;
}
/// The same of elements that a commit made: of those that the judge has not measured.
template <int D>
void know_shapes(Adaptation<D>& r, std::span<const ElementId> created) {
    if (!r.mesh.is_curved()) return;  // all are the judge's
    auto shapes = take(std::move(r.shapes));
    for (const ElementId e : created)
        if (!r.mesh.is_free(e) && shapes[e.index()] < 0) shapes[e.index()] = shape_of(r, e);
    r.shapes = std::move(shapes);
}

/// Of elements whose shapes are known: the worst.
template <int D>
[[nodiscard]] double worst_known_shape_of(const Adaptation<D>& r, std::span<const ElementId> elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, r.shapes[e.index()]);
    return worst;
}

}  // namespace camber
