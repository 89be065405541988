// Samples of the faces and edges of a model: position, weight and use where the mesh has no facet.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "read.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.surface;
import camber.cad;

using namespace camber;
using namespace cad_tests;

namespace {

template <class T>
T value(Outcome<T> outcome) {
    if (!outcome) FAIL(describe(outcome.error()));
    return std::move(*outcome);
}

double measure_of(const GeometrySamples<3>& samples, GeometryKind kind) {
    double sum = 0;
    for (const auto& [entity, begin, end] : samples.entities)
        if (entity.kind == kind)
            for (std::size_t i = begin; i < end; ++i) sum += samples.weights[i];
    return sum;
}

constexpr double pi = 3.141592653589793;

}  // namespace

TEST_CASE("samples lie on their entity and represent its area or length") {
    struct Known {
        Kind kind;
        std::array<double, 3> sizes;
        double area, length;
    };
    for (const Known& known :
         {Known{Kind::box, {1, 2, 3}, 22, 24}, Known{Kind::ball, {2, 0, 0}, 16 * pi, -1},
          Known{Kind::cylinder, {0.5, 2, 0}, 2.5 * pi, -1}, Known{Kind::torus, {2, 0.5, 0}, 4 * pi * pi, -1},
          Known{Kind::nurbs_ball, {2, 0, 0}, 16 * pi, -1}}) {
        const CadModel model = model_of(known.kind, known.sizes);
        const auto samples = value(samples_of<3>(model, 5000, {}));
        CHECK(samples.points.size() > 4000);
        CHECK(samples.points.size() < 40000);
        CHECK(measure_of(samples, GeometryKind::surface) == doctest::Approx(known.area).epsilon(0.02));
        if (known.length > 0)
            CHECK(measure_of(samples, GeometryKind::curve) == doctest::Approx(known.length).epsilon(1e-6));
        std::size_t faces = 0;
        for (const auto& [entity, begin, end] : samples.entities) {
            REQUIRE(end > begin);
            faces += entity.kind == GeometryKind::surface ? 1 : 0;
            for (std::size_t i = begin; i < end; i += 97) {
                const auto number = static_cast<std::size_t>(entity.id);
                const CadFoot foot = entity.kind == GeometryKind::surface
                                         ? closest_on_face(model, number, samples.points[i])
                                         : closest_on_edge(model, number, samples.points[i]);
                CHECK(foot.distance < 1e-11);
            }
        }
        CHECK(faces == model.faces());
    }
}

TEST_CASE("small and trimmed faces have samples for any number of threads") {
    const CadModel model = model_of(Kind::filleted_box, {10, 0.05, 0});
    const auto samples = value(samples_of<3>(model, 500, {.threads = 1}));
    std::size_t faces = 0;
    for (const auto& of : samples.entities) faces += of.entity.kind == GeometryKind::surface ? 1 : 0;
    CHECK(faces == model.faces());
    const auto again = value(samples_of<3>(model, 500, {.threads = 3}));
    REQUIRE(again.points.size() == samples.points.size());
    for (std::size_t i = 0; i < samples.points.size(); ++i) {
        CHECK(again.points[i] == samples.points[i]);
        CHECK(again.weights[i] == samples.weights[i]);
    }
}

TEST_CASE("fillets that the mesh lacks appear in the distance from the model") {
    // A lattice of the box without its fillets: each facet lies on a face, except for the parts cut off by fillets.
    const double r = 0.2;
    const CadModel model = model_of(Kind::filleted_box, {1, r, 0});
    BoxOptions<3> box;
    const auto mesh = value(elevate(value(generate(box)), {}));
    const auto features = value(find_features(mesh.linear, mesh.edges, FeatureOptions<3>{}, {}));
    const auto association = associate(mesh.linear, mesh.edges, model, {});
    REQUIRE(association);
    const Geometry<3> geometry(CadGeometry{model, *association, mesh.linear});
    const auto samples = value(samples_of<3>(model, 4096, {}));
    const auto found = value(two_sided_distances<3>(mesh, mesh.mid_nodes.view(), features, geometry, samples, {}));
    // The centre of a rounded corner is r (1 − 1/√3) from the planes of the box.
    CHECK(found.to_boundary.largest == doctest::Approx(r * (1 - 1 / std::sqrt(3.0))).epsilon(0.1));
    std::size_t measured = 0;
    for (const auto& entity : found.entities)
        if (entity.entity.kind == GeometryKind::surface) measured += entity.to_boundary.samples > 0 ? 1 : 0;
    CHECK(measured == model.faces());
}
