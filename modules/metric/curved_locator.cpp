module;
#include <cstddef>
#include <utility>
module camber.metric;
import :curved_locator;
import :curved_simplex;
import camber.core;
import camber.box_tree;

namespace camber {

namespace {

template <int D, class Simplex>
Outcome<BoxTree<D>> tree_of(std::size_t n, const Execution& execution, const Simplex& simplex) {
    auto boxes = map_each(execution, n, [&](std::size_t i) { return simplex(i).box(); });
    if (!boxes) return fail(boxes.error());
    return guarded([&]() -> Outcome<BoxTree<D>> { return BoxTree<D>(*boxes); });
}

}  // namespace

template <int D>
ElementId CurvedLocator<D>::hint_for(const Vec<D>& p) const {
    ElementId hint;
    element_tree.containing(p, [&](std::size_t e) {
        if (!hint.valid() && curved_element(mesh, ElementId(e)).box().contains(p)) hint = ElementId(e);
    });
    return hint;
}

template <int D>
Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                              const Execution& execution) {
    CurvedLocator<D> locator;
    auto across = neighbours(mesh.linear, balls, part_of(execution, 0, 0.5));
    if (!across) return fail(across.error());
    locator.neighbours = std::move(*across);
    locator.boundary = boundary_faces<D>(locator.neighbours);
    locator.mesh = std::move(mesh);
    auto elements = tree_of<D>(locator.mesh.linear.elements.size(), part_of(execution, 0.5, 0.8),
                               [&](std::size_t e) { return curved_element(locator.mesh, ElementId(e)); });
    if (!elements) return fail(elements.error());
    locator.element_tree = std::move(*elements);
    auto faces = tree_of<D>(locator.boundary.size(), part_of(execution, 0.8, 1),
                            [&](std::size_t f) { return curved_face(locator.mesh, locator.boundary[f]); });
    if (!faces) return fail(faces.error());
    locator.boundary_tree = std::move(*faces);
    return locator;
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template ElementId CurvedLocator<D>::hint_for(const Vec<D>&) const;                                      \
    template Outcome<CurvedLocator<D>> make_curved_locator<D>(QuadraticMesh<D>, const Incidence<ElementId>&, \
                                                              const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
