// Closest points on faces and edges, compared with the exact surfaces.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>
#include <rapidcheck.h>

#include "property.hpp"
#include "read.hpp"

import camber.core;
import camber.surface;
import camber.cad;

using namespace camber;
using namespace cad_tests;
using testing::property;

namespace {

double number(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 1000001) / 1e6; }

Vec<3> direction() {
    const double z = number(-1, 1), angle = number(-3.15, 3.15), r = std::sqrt(std::fmax(0.0, 1 - z * z));
    return {{r * std::cos(angle), r * std::sin(angle), z}};
}

struct Foot {
    Vec<3> point, normal;
};

Foot on_sphere(double radius, const Vec<3>& p) { return {radius * normalised(p), normalised(p)}; }

Foot on_torus(double major, double minor, const Vec<3>& p) {
    const double r = std::hypot(p[0], p[1]);
    const Vec<3> centre{{major * p[0] / r, major * p[1] / r, 0}};
    const Vec<3> normal = normalised(p - centre);
    return {centre + minor * normal, normal};
}

/// Largest distance of a point from its surface, as a share of the radius of curvature.
constexpr double off = 0.3;

template <class Near, class True>
void check_projection(const CadModel& model, Near&& near, True&& true_foot, double size) {
    std::size_t face = 0;
    const Vec<3> p = near();
    double least = 1e300;
    for (std::size_t f = 0; f < model.faces(); ++f)
        if (const double d = closest_on_face(model, f, p).distance; d < least) {
            least = d;
            face = f;
        }
    const CadFoot foot = closest_on_face(model, face, p);
    const Foot expected = true_foot(p);
    RC_ASSERT(distance(foot.point, expected.point) <= 1e-12 * size);
    RC_ASSERT(std::abs(foot.distance - distance(expected.point, p)) <= 1e-12 * size);
    RC_ASSERT(norm(foot.normal - expected.normal) <= 1e-9);
    // The projection is idempotent to the last bit.
    const CadFoot again = closest_on_face(model, face, foot.point);
    RC_ASSERT(again.point == foot.point);
    RC_ASSERT(again.distance == 0);
    const auto evaluated = point_on_face(model, face, foot.parameters);
    RC_ASSERT(distance(evaluated.point, foot.point) <= 1e-12 * size);
}

}  // namespace

TEST_CASE("points near a sphere are projected onto it, at seam and poles too") {
    for (const Kind kind : {Kind::ball, Kind::nurbs_ball, Kind::revolved_ball}) {
        const CadModel model = model_of(kind, {1.3, 0, 0});
        CHECK(model.faces() == 1);
        const auto near = [] { return number(1 - off, 1 + off) * 1.3 * direction(); };
        property("points near a sphere are projected onto it",
                 [&] { check_projection(model, near, [](const Vec<3>& p) { return on_sphere(1.3, p); }, 1.3); });
        for (const Vec<3>& p : {Vec<3>{{0, 0, 1.2}}, Vec<3>{{0, 0, -1.4}}, Vec<3>{{1.4, 0, 0}}, Vec<3>{{1e-9, 0, 1.2}},
                                Vec<3>{{1.2, 1e-13, 0.1}}, Vec<3>{{1.2, -1e-13, 0.1}}}) {
            const CadFoot foot = closest_on_face(model, 0, p);
            // At a pole the parameters of a spline are undefined, and distances below the root of rounding are not
            // resolved.
            CHECK(distance(foot.point, 1.3 * normalised(p)) <= (kind == Kind::ball ? 2e-12 : 2e-9));
            CHECK(distance(foot.normal, normalised(p)) <= 1e-8);
        }
    }
}

TEST_CASE("points near a torus are projected onto it") {
    for (const Kind kind : {Kind::torus, Kind::nurbs_torus}) {
        const CadModel model = model_of(kind, {2, 0.5, 0});
        const auto near = [] {
            const Vec<3> around = direction();
            const Vec<3> ring = normalised(Vec<3>{{around[0] + 1e-3, around[1], 0}});
            const double tube = number(-3.15, 3.15);
            const double r = 0.5 * number(1 - off, 1 + off);
            return (2 + r * std::cos(tube)) * ring + Vec<3>{{0, 0, r * std::sin(tube)}};
        };
        property("points near a torus are projected onto it",
                 [&] { check_projection(model, near, [](const Vec<3>& p) { return on_torus(2, 0.5, p); }, 2); });
    }
}

TEST_CASE("points near a cylinder, a cone and a box are projected onto them") {
    const CadModel cylinder = model_of(Kind::cylinder, {0.5, 2, 0});
    CHECK(cylinder.faces() == 3);
    CHECK(cylinder.edges() == 3);
    property("points near a cylinder are projected onto its mantle", [&] {
        const auto near = [] {
            const double angle = number(-3.15, 3.15), r = 0.5 * number(0.95, 1.05);
            return Vec<3>{{r * std::cos(angle), r * std::sin(angle), number(0.1, 1.9)}};
        };
        check_projection(
            cylinder, near,
            [](const Vec<3>& p) {
                const Vec<3> n = normalised(Vec<3>{{p[0], p[1], 0}});
                return Foot{0.5 * n + Vec<3>{{0, 0, p[2]}}, n};
            },
            2);
    });
    const CadModel cone = model_of(Kind::cone, {1, 0, 2});
    property("points near a cone are projected onto its mantle", [&] {
        const Vec<3> slope = normalised(Vec<3>{{-1, 0, 2}}), normal = normalised(Vec<3>{{2, 0, 1}});
        const double along = number(0.2, 2.0), away = number(-0.05, 0.05), angle = number(-3.15, 3.15);
        const Vec<3> profile = Vec<3>{{1, 0, 0}} + along * slope;
        const auto turned = [&](const Vec<3>& x) {
            return Vec<3>{{x[0] * std::cos(angle), x[0] * std::sin(angle), x[2]}};
        };
        check_projection(
            cone, [&] { return turned(profile + away * normal); },
            [&](const Vec<3>&) { return Foot{turned(profile), turned(normal)}; }, 2);
    });
    const CadModel box = model_of(Kind::box, {1, 2, 3});
    CHECK(box.faces() == 6);
    CHECK(box.edges() == 12);
    CHECK(box.vertices() == 8);
    property("points near a box are projected onto its side or the nearest edge", [&] {
        const Vec<3> p{{number(-1, 2), number(-1, 3), number(3, 4)}};
        const Vec<3> expected{{std::fmin(1.0, std::fmax(0.0, p[0])), std::fmin(2.0, std::fmax(0.0, p[1])), 3}};
        double least = 1e300;
        for (std::size_t f = 0; f < 6; ++f) least = std::fmin(least, closest_on_face(box, f, p).distance);
        RC_ASSERT(std::abs(least - distance(p, expected)) <= 1e-14 * 4);
    });
}

TEST_CASE("the nearest point of a face lies within its trimmed boundary") {
    const CadModel half = model_of(Kind::half_torus, {2, 0.5, 0});
    for (std::size_t f = 0; f < half.faces(); ++f) {
        // The point is on the side of the missing half: the closest points are on the circles or discs of the cut.
        const CadFoot foot = closest_on_face(half, f, {{1.9, -0.7, 0.2}});
        CHECK(foot.point[1] >= -1e-12);
        CHECK(std::abs(foot.distance - distance(foot.point, Vec<3>{{1.9, -0.7, 0.2}})) <= 1e-15);
    }
}

TEST_CASE("points near the edges of a cylinder are projected onto them") {
    const CadModel model = model_of(Kind::cylinder, {0.5, 2, 0});
    property("points near the rim of a cylinder are projected onto the circle", [&] {
        const double angle = number(-3.15, 3.15), r = 0.5 * number(0.6, 1.4), z = number(-0.1, 0.1);
        const Vec<3> p{{r * std::cos(angle), r * std::sin(angle), z}};
        const Vec<3> expected{{0.5 * std::cos(angle), 0.5 * std::sin(angle), 0}};
        CadFoot best{{}, {}, {}, 1e300};
        std::size_t edge = 0;
        for (std::size_t e = 0; e < model.edges(); ++e)
            if (const CadFoot foot = closest_on_edge(model, e, p); foot.distance < best.distance) {
                // The seam is an edge of the model as well.
                const Vec<3> tangent = point_on_edge(model, e, foot.parameters[0]).tangents[0];
                if (std::abs(tangent[2]) > 0.1 * norm(tangent)) continue;
                best = foot;
                edge = e;
            }
        RC_ASSERT(distance(best.point, expected) <= 1e-13);
        const auto at = point_on_edge(model, edge, best.parameters[0]);
        RC_ASSERT(std::abs(dot(at.tangents[0], p - best.point)) <= 1e-12);
        RC_ASSERT(closest_on_edge(model, edge, best.point).point == best.point);
    });
}

TEST_CASE("a search from any start finds the nearest point of the face") {
    struct Model {
        Kind kind;
        std::array<double, 3> sizes;
    };
    for (const auto& [kind, sizes] :
         {Model{Kind::nurbs_ball, {1.3, 0, 0}}, Model{Kind::nurbs_torus, {2, 0.5, 0}}, Model{Kind::cone, {1, 0.4, 2}},
          Model{Kind::half_torus, {2, 0.5, 0}}, Model{Kind::skew_cone, {1, 0.4, 2}}}) {
        CAPTURE(static_cast<int>(kind));
        const CadModel model = model_of(kind, sizes);
        property("a search from any start has the distance of a search without one", [&] {
            const auto face = static_cast<std::size_t>(number(0, 0.999) * static_cast<double>(model.faces()));
            const Vec<3> p{{number(-3, 3), number(-3, 3), number(-2, 3)}};
            const Vec<3> elsewhere{{number(-3, 3), number(-3, 3), number(-2, 3)}};
            const auto near = closest_on_face(model, face, elsewhere).parameters;
            const CadFoot plain = closest_on_face(model, face, p), found = closest_on_face(model, face, p, near);
            RC_ASSERT(std::abs(found.distance - plain.distance) <= 1e-9 * plain.distance + 1e-12);
            RC_ASSERT(std::abs(distance(p, found.point) - found.distance) <= 1e-12);
        });
    }
}

TEST_CASE("the nearest of many faces is the minimum over all of them") {
    const CadModel model = model_of(Kind::filleted_box, {2, 0.3, 0});
    REQUIRE(model.faces() == 26);
    std::vector<std::size_t> all, some;
    for (std::size_t f = 0; f < model.faces(); ++f) {
        all.push_back(f);
        if (f % 2 == 0) some.push_back(f);
    }
    property("nearest_face returns the face of minimum distance", [&] {
        const Vec<3> p{{number(-1, 3), number(-1, 3), number(-1, 3)}};
        for (const auto& faces : {all, some}) {
            std::size_t nearest = faces.front();
            double least = 1e300;
            for (const std::size_t f : faces)
                if (const double d = closest_on_face(model, f, p).distance; d < least) {
                    least = d;
                    nearest = f;
                }
            RC_ASSERT(nearest_face(model, faces, p) == nearest);
        }
    });
}
