// Pairs of facets: known positions, invariance and limits of rounding.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "facets.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.crossing;

using namespace camber;
using camber::testing::property;
using namespace camber::testing;

namespace {

std::uint64_t seed() { return *rc::gen::arbitrary<std::uint64_t>(); }

/// Unit normal of the straight facet.
Vec<2> normal_of(const NodalFacet<2>& f) {
    const Vec<2> along = f.nodes[1] - f.nodes[0];
    return normalised(Vec<2>{{-along[1], along[0]}});
}
Vec<3> normal_of(const NodalFacet<3>& f) { return normalised(cross(f.nodes[1] - f.nodes[0], f.nodes[2] - f.nodes[0])); }

/// A facet that crosses the other one at its position xi, with its own position eta there.
template <int D>
NodalFacet<D> through(const NodalFacet<D>& other, const Barycentric<D - 1>& xi, Engine& engine) {
    const auto curve = bezier_of(other);
    const auto slopes = curve.derivatives(xi);
    NodalFacet<D> facet = random_facet<D>(engine, 0.2);
    const auto eta = random_place<D>(engine);
    const Vec<D> move = curve.point(xi) - bezier_of(facet).point(eta);
    facet = mapped<D>(facet, [&](const Vec<D>& p) { return p + move; });
    // Nearly tangent or degenerate pairs belong to other tests.
    const auto own = bezier_of(facet).derivatives(eta);
    bool across = true;
    if constexpr (D == 2) {
        across = std::abs(cross(normalised(slopes[0]), normalised(own[0]))) > 0.2;
    } else {
        const Vec<3> n = cross(slopes[0], slopes[1]), m = cross(own[0], own[1]);
        across = norm(n) > 0.1 && norm(m) > 0.1 && norm(cross(normalised(n), normalised(m))) > 0.2;
    }
    RC_PRE(across);
    for (const double x : xi) RC_PRE(x > 0.05);
    for (const double x : eta) RC_PRE(x > 0.05);
    return facet;
}

template <int D>
void check_pairs() {
    const std::string d = D == 2 ? "2D " : "3D ";
    property(d + "facets on two sides of a plane are disjoint", [] {
        Engine engine(seed());
        const Vec<D> n = normalised(random_vector<D>(engine));
        RC_PRE(norm(n) > 0.5);
        const auto beyond = [&](const NodalFacet<D>& f, double side) {
            // Bézier points are within 3 times the size of a node, so the shift moves all to one side.
            double least = 1e300;
            for (const Vec<D>& p : bezier_of(f).control) least = std::min(least, side * dot(n, p));
            return mapped<D>(f, [&](const Vec<D>& p) { return p - (side * (least - 1e-9)) * n; });
        };
        const auto a = beyond(random_facet<D>(engine, 0.5), 1), b = beyond(random_facet<D>(engine, 0.5), -1);
        RC_ASSERT(crossing_of(a, b) == Crossing::disjoint);
        RC_ASSERT(crossing_of(b, a) == Crossing::disjoint);
    });
    property(d + "facets with a common transversal inner point cross in any numbering", [] {
        Engine engine(seed());
        const NodalFacet<D> a = random_facet<D>(engine, 0.2);
        const NodalFacet<D> b = through<D>(a, random_place<D>(engine), engine);
        const int turn = *rc::gen::inRange(0, 3);
        const bool mirrored = *rc::gen::arbitrary<bool>();
        RC_ASSERT(crossing_of(a, b) == Crossing::crossing);
        RC_ASSERT(crossing_of(renumbered(b, turn, mirrored), a) == Crossing::crossing);
    });
    property(d + "verdicts of random facets are symmetric and agree with samples",
             [] {
                 Engine engine(seed());
                 const auto a = random_facet<D>(engine, 0.3), b = random_facet<D>(engine, 0.3);
                 const Crossing found = crossing_of(a, b);
                 RC_ASSERT(found != Crossing::undecided);
                 RC_ASSERT(crossing_of(b, a) == found);
                 const bool meet = newton_meets(a, b, 1e-9, engine);
                 RC_ASSERT(!meet || found == Crossing::crossing);
                 // Pairs that barely meet are so rare that many starts are affordable.
                 RC_ASSERT(meet || found == Crossing::disjoint || newton_meets(a, b, 0, engine, 1000));
             },
             {.count = 100});
    property(d + "facets with an exact common inner point are never disjoint",
             [] {
                 // Integer nodes, multiples of 64, and weights that are multiples of 1/4: the point is an integer, and
                 // the second facet is moved to it without rounding.
                 Engine engine(seed());
                 const auto whole = [&] {
                     NodalFacet<D> f;
                     for (Vec<D>& node : f.nodes)
                         for (double& x : node.c) x = 64 * std::floor(uniform(engine, -4, 5));
                     return f;
                 };
                 const auto place = [&] {
                     Barycentric<D - 1> xi{};
                     for (int k = 0; k < 4; ++k) xi[static_cast<std::size_t>(uniform(engine, 0, D - 1e-9))] += 0.25;
                     return xi;
                 };
                 const NodalFacet<D> a = whole(), b = whole();
                 const auto xi = place(), eta = place();
                 const auto inner = [](const auto& weights) {
                     return std::all_of(weights.begin(), weights.end(), [](double w) { return w > 0; });
                 };
                 RC_PRE(inner(xi) && inner(eta));
                 const Vec<D> move = bezier_of(a).point(xi) - bezier_of(b).point(eta);
                 const NodalFacet<D> moved = mapped<D>(b, [&](const Vec<D>& p) { return p + move; });
                 RC_PRE(!(moved == a));
                 RC_ASSERT(crossing_of(a, moved, 500) != Crossing::disjoint);
             },
             {.count = 300});
    property(d + "verdicts do not depend on the unit of length", [] {
        Engine engine(seed());
        const auto a = random_facet<D>(engine, 0.3), b = random_facet<D>(engine, 0.3);
        const Crossing found = crossing_of(a, b);
        for (const int power : {-190, -60, 60, 190}) {
            const auto scaled = [&](const Vec<D>& p) { return p * std::ldexp(1.0, power); };
            RC_ASSERT(crossing_of(mapped<D>(a, scaled), mapped<D>(b, scaled)) == found);
        }
    });
    property(d + "verdicts of details of 1e-6 do not change at a distance of 1e6", [] {
        Engine engine(seed());
        const NodalFacet<D> a = random_facet<D>(engine, 0.2);
        const NodalFacet<D> b = through<D>(a, random_place<D>(engine), engine);
        Vec<D> far;
        for (double& x : far.c) x = 1e6;
        const auto moved = [&](const Vec<D>& p) { return p * 1e-6 + far; };
        RC_ASSERT(crossing_of(mapped<D>(a, moved), mapped<D>(b, moved)) == Crossing::crossing);
        const Vec<D> n = normal_of(a);
        const auto beside = mapped<D>(a, [&](const Vec<D>& p) { return p + 0.1 * n; });
        const Crossing near = crossing_of(a, beside);
        RC_ASSERT(near != Crossing::undecided);
        RC_ASSERT(crossing_of(mapped<D>(a, moved), mapped<D>(beside, moved)) == near);
    });
    property(d + "flat facets with a gap of 1e-9 are disjoint", [] {
        Engine engine(seed());
        const NodalFacet<D> a = random_facet<D>(engine, 0);
        const Vec<D> n = normal_of(a);
        double spread = 1;
        if constexpr (D == 3) spread = norm(cross(a.nodes[1] - a.nodes[0], a.nodes[2] - a.nodes[0]));
        RC_PRE(spread > 0.05);
        const auto b = mapped<D>(a, [&](const Vec<D>& p) { return p + 1e-9 * n; });
        RC_ASSERT(crossing_of(a, b) == Crossing::disjoint);
        RC_ASSERT(crossing_of(b, renumbered(a, 1, false)) == Crossing::disjoint);
    });
    property(d + "a slightly bent facet is disjoint from its copy and from itself", [] {
        Engine engine(seed());
        const NodalFacet<D> a = random_facet<D>(engine, 0.02);
        RC_ASSERT(crossing_of(a, a) == Crossing::disjoint);
        RC_ASSERT(crossing_of(a, renumbered(a, 1, true)) == Crossing::disjoint);
        if constexpr (D == 3) RC_PRE(norm(cross(a.nodes[1] - a.nodes[0], a.nodes[2] - a.nodes[0])) > 0.5);
        RC_ASSERT(crossing_of_itself(a) == Crossing::disjoint);
    });
}

/// A parabola that starts at v along t and bends towards n.
NodalFacet<2> branch(const Vec<2>& v, const Vec<2>& t, const Vec<2>& n, double bend) {
    return {{v, v + t + bend * n, v + 0.5 * t + 0.25 * bend * n}};
}

}  // namespace

TEST_CASE("verdicts of facet pairs agree with known positions and samples, 2D") { check_pairs<2>(); }
TEST_CASE("verdicts of facet pairs agree with known positions and samples, 3D") { check_pairs<3>(); }

TEST_CASE("verdicts of 2D facets account for common vertices") {
    property("a smooth curve or a corner that is cut anywhere does not cross itself", [] {
        Engine engine(seed());
        const Vec<2> v = random_vector<2>(engine), t = random_vector<2>(engine);
        RC_PRE(norm(t) > 0.1);
        const Vec<2> n{{-t[1], t[0]}};
        const auto a = branch(v, t, n, uniform(engine, -2, 2));
        const auto b = branch(v, t * -uniform(engine, 0.01, 3), n, uniform(engine, -2, 2));
        RC_ASSERT(crossing_of(a, b) == Crossing::disjoint);
        const double turn = uniform(engine, 0.05, 3);
        const Vec<2> u = std::cos(turn) * t + std::sin(turn) * n;
        RC_ASSERT(crossing_of(a, branch(v, u, Vec<2>{{-u[1], u[0]}}, 0)) != Crossing::undecided);
    });
    property("two curves from a common vertex that meet again cross", [] {
        Engine engine(seed());
        // y = x (1 − x) and y = s x, s in (0, 0.9): they meet at x = 1 − s.
        const double s = uniform(engine, 0.05, 0.9);
        const NodalFacet<2> parabola{{Vec<2>{{0, 0}}, Vec<2>{{1, 0}}, Vec<2>{{0.5, 0.25}}}};
        RC_ASSERT(crossing_of(parabola, straight_facet<2>({Vec<2>{{0, 0}}, Vec<2>{{1, s}}})) == Crossing::crossing);
        RC_ASSERT(crossing_of(parabola, straight_facet<2>({Vec<2>{{0, 0}}, Vec<2>{{1, -s}}})) == Crossing::disjoint);
        RC_ASSERT(crossing_of(parabola, straight_facet<2>({Vec<2>{{0, 0}}, Vec<2>{{1, 1 + s}}})) == Crossing::disjoint);
    });
    SUBCASE("two curves between the same vertices are disjoint") {
        const Vec<2> a{{0, 0}}, b{{1, 0}};
        const NodalFacet<2> upper{{a, b, Vec<2>{{0.5, 0.1}}}}, lower{{b, a, Vec<2>{{0.5, -0.1}}}};
        CHECK(crossing_of(upper, lower) == Crossing::disjoint);
        CHECK(crossing_of(upper, NodalFacet<2>{{a, b, Vec<2>{{0.5, 0.1 + 1e-3}}}}) == Crossing::disjoint);
    }
    SUBCASE("curves that touch with a common tangent are undecided") {
        const NodalFacet<2> up{{Vec<2>{{-1, 1}}, Vec<2>{{1, 1}}, Vec<2>{{0, 0}}}};
        const NodalFacet<2> down{{Vec<2>{{-1, -1}}, Vec<2>{{1, -1}}, Vec<2>{{0, 0}}}};
        CHECK(crossing_of(up, down) == Crossing::undecided);
        CHECK(crossing_of(up, mapped<2>(down, [](const Vec<2>& p) { return p - Vec<2>{{0, 1e-9}}; })) ==
              Crossing::disjoint);
        CHECK(crossing_of(up, mapped<2>(down, [](const Vec<2>& p) { return p + Vec<2>{{0, 1e-5}}; })) ==
              Crossing::crossing);
    }
}

TEST_CASE("the quick test of straight facets accepts only disjoint pairs") {
    property("are_surely_disjoint accepts only disjoint pairs for any common vertices", [] {
        Engine engine(seed());
        const auto check_dimension = [&]<int D>() {
            const int shared = *rc::gen::inRange(0, D + 1);
            NodalFacet<D> f = random_facet<D>(engine, 0), g = random_facet<D>(engine, 0);
            // Moves some vertices into one plane or onto one line.
            if (*rc::gen::arbitrary<bool>())
                for (NodalFacet<D>* facet : {&f, &g})
                    for (int i = 0; i < D; ++i) facet->nodes[i][D - 1] = std::round(4 * facet->nodes[i][D - 1]) / 4;
            for (int i = 0; i < shared; ++i) g.nodes[i] = f.nodes[i];
            std::array<Vec<D>, D> of_f, of_g;
            for (int i = 0; i < D; ++i) of_f[i] = f.nodes[i], of_g[i] = g.nodes[i];
            f = straight_facet<D>(of_f);
            g = renumbered(straight_facet<D>(of_g), *rc::gen::inRange(0, 3), *rc::gen::arbitrary<bool>());
            if (are_surely_disjoint(f, g)) RC_ASSERT(crossing_of(f, g) == Crossing::disjoint);
            if (shared == D) RC_ASSERT(are_surely_disjoint(f, g));
        };
        check_dimension.template operator()<2>();
        check_dimension.template operator()<3>();
    });
    SUBCASE("the quick test accepts facets of a smooth wall with a common vertex or edge") {
        for (const double height : {0.0, 0.1, 0.7, -0.3}) {
            std::vector<NodalFacet<3>> fan;
            const auto rim = [](int i) { return Vec<3>{{std::cos(0.9 * i), std::sin(0.9 * i), 0}}; };
            for (int i = 0; i < 6; ++i) fan.push_back(straight_facet<3>({Vec<3>{{0, 0, height}}, rim(i), rim(i + 1)}));
            for (const auto& f : fan)
                for (const auto& g : fan) CHECK(are_surely_disjoint(f, g));
        }
    }
}

TEST_CASE("crossing_of handles degenerate facets") {
    const Vec<3> o{}, x{{1, 0, 0}}, y{{0, 1, 0}}, z{{0, 0, 1}};
    const auto flat = straight_facet<3>({o, x, y});
    SUBCASE("facets without area are not disjoint from facets that they touch") {
        const auto line = straight_facet<3>({x * 0.2 + y * 0.2 - z, x * 0.2 + y * 0.2 + z, x * 0.2 + y * 0.2});
        CHECK(crossing_of(flat, line) != Crossing::disjoint);
        const auto point = straight_facet<3>({z, z, z});
        CHECK(crossing_of(flat, point) == Crossing::disjoint);
        CHECK(crossing_of(point, point) == Crossing::disjoint);
        CHECK(crossing_of_itself(point) == Crossing::undecided);
    }
    SUBCASE("a vertex on a face or an edge along it is a contact") {
        CHECK(crossing_of(flat, straight_facet<3>({(x + y) * 0.25, z, x + z})) == Crossing::touching);
        CHECK(crossing_of(flat, straight_facet<3>({(x + y) * 0.25, x * 0.25, x + z})) == Crossing::touching);
    }
    SUBCASE("coplanar facets are disjoint only if they do not overlap") {
        CHECK(crossing_of(flat, straight_facet<3>({(x + y) * 0.25, x + y, x})) != Crossing::disjoint);
        CHECK(crossing_of(flat, straight_facet<3>({x + y * 0.5, x + y, x * 0.5 + y})) == Crossing::disjoint);
    }
    SUBCASE("facets folded at a common edge are disjoint unless the angle is 0") {
        for (const double angle : {1e-6, 1e-3, 0.1, 1.0, 2.0, 3.1})
            CHECK(crossing_of(flat, straight_facet<3>({x, o, x + std::cos(angle) * y + std::sin(angle) * z})) ==
                  Crossing::disjoint);
        CHECK(crossing_of(flat, straight_facet<3>({x, o, x + y})) != Crossing::disjoint);
    }
    SUBCASE("facets with non-finite nodes are undecided") {
        auto broken = flat;
        broken.nodes[4][1] = std::numeric_limits<double>::quiet_NaN();
        CHECK(crossing_of(flat, broken) == Crossing::undecided);
        CHECK(crossing_of_itself(broken) == Crossing::undecided);
    }
    SUBCASE("a triangle folded through itself crosses itself") {
        // Whitney's umbrella (u v, u, v²): (0, v) and (0, −v) have the same image.
        const auto umbrella = [](double u, double v) { return Vec<3>{{u * v, u, v * v}}; };
        const std::array<std::array<double, 2>, 3> corners{{{-0.5, -1}, {-0.4, 1}, {1, 0.1}}};
        NodalFacet<3> facet;
        for (int i = 0; i < 3; ++i) {
            const auto& a = corners[i];
            const auto& b = corners[(i + 1) % 3];
            facet.nodes[i] = umbrella(a[0], a[1]);
            facet.nodes[3 + i] = umbrella((a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
        }
        CHECK(crossing_of_itself(facet) == Crossing::crossing);
    }
}
