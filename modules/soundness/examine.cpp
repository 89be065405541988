module;
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
module camber.soundness;
import camber.core;
import camber.bezier;
import camber.validity;
import :examination;

namespace camber {

namespace {

template <int D>
Outcome<Examination<D>> examine_with(const LinearMesh<D>& mesh, const Buffer<double>& volumes,
                                     const ExamineOptions& options, const Execution& execution) {
    Examination<D> x;
    x.soundness.dimension = D;
    x.soundness.empty = mesh.elements.vertices.empty() && mesh.facets.vertices.empty();
    const Execution quiet = without_progress(execution);
    auto elements_of = balls(mesh, part_of(execution, 0, 0.13));
    if (!elements_of) return fail(elements_of.error());
    x.elements_of = std::move(*elements_of);
    auto facets_of = facet_balls(mesh, quiet);
    if (!facets_of) return fail(facets_of.error());
    x.facets_of = std::move(*facets_of);
    auto done =
        examine_faces(mesh, x, part_of(execution, 0.13, 0.73))
            .and_then([&](Done) { return examine_orientation(mesh, volumes, x, part_of(execution, 0.73, 0.83)); })
            .and_then([&](Done) { return examine_scale(mesh, x, part_of(execution, 0.83, 0.89)); })
            .and_then([&](Done) { return examine_vertices(mesh, x, part_of(execution, 0.89, 0.94)); })
            .and_then([&](Done) { return examine_boundary(mesh, x, quiet); })
            .and_then([&](Done) { return examine_walls(mesh, options, x, part_of(execution, 0.96, 1)); });
    if (!done) return fail(done.error());
    return x;
}

}  // namespace

template <int D>
Outcome<Examination<D>> examine_all(const LinearMesh<D>& mesh, const Execution& execution,
                                    const ExamineOptions& options) {
    auto volumes = map_each(part_of(execution, 0, 0.14), mesh.elements.size(), [&](std::size_t e) {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
        return signed_volume<D>(p);
    });
    if (!volumes) return fail(volumes.error());
    return examine_with(mesh, *volumes, options, part_of(execution, 0.14, 1));
}

template <int D>
Outcome<Examination<D>> examine_all(const QuadraticMesh<D>& mesh, const Execution& execution,
                                    const ExamineOptions& options) {
    auto volumes = map_each(part_of(execution, 0, 0.21), mesh.linear.elements.size(), [&](std::size_t e) {
        return signed_volume(nodal_element<D>(mesh, mesh.mid_nodes.view(), ElementId(e)));
    });
    if (!volumes) return fail(volumes.error());
    auto x = examine_with(mesh.linear, *volumes, options, part_of(execution, 0.21, 0.72));
    if (!x) return x;
    auto done = examine_scale(mesh, *x, without_progress(execution)).and_then([&](Done) {
        return examine_nodes(mesh, *x, part_of(execution, 0.72, 1));
    });
    if (!done) return fail(done.error());
    return x;
}

template <int D>
Outcome<Soundness> examine(const LinearMesh<D>& mesh, const ExamineOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<Soundness> {
        return examine_all(mesh, execution, options).map([](const Examination<D>& x) { return x.soundness; });
    });
}

template <int D>
Outcome<Soundness> examine(const QuadraticMesh<D>& mesh, const ExamineOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<Soundness> {
        return examine_all(mesh, execution, options).map([](const Examination<D>& x) { return x.soundness; });
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Examination<D>> examine_all<D>(const LinearMesh<D>&, const Execution&, const ExamineOptions&);    \
    template Outcome<Examination<D>> examine_all<D>(const QuadraticMesh<D>&, const Execution&, const ExamineOptions&); \
    template Outcome<Soundness> examine<D>(const LinearMesh<D>&, const ExamineOptions&, const Execution&);             \
    template Outcome<Soundness> examine<D>(const QuadraticMesh<D>&, const ExamineOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
