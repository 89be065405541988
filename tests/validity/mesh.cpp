#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stop_token>
#include <string>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

template <int D>
void test_against_elements() {
    property(
        "validate returns the verdicts and the minimum of the elements, " + std::to_string(D) + "D",
        [] {
            auto random = random_source();
            const auto p = planned<D>(random, D == 2 ? 8 : 3, uniform(random, 0, 0.3), uniform(random, 0, 0.2));
            const double bound = uniform(random, 0, 1) < 0.5 ? 1e-3 : 0.6;
            const auto v = validate(p.mesh, p.proposal, bound, Execution{1}).value().validation();
            std::size_t invalid = 0;
            std::size_t undecided = 0;
            std::vector<std::pair<ElementId, Verdict>> not_positive;
            double smallest = 1e300;
            for (std::size_t e = 0; e < p.mesh.linear.elements.size(); ++e) {
                const auto form = nodal_form<D>(p.mesh.linear.points, p.proposal.mid_nodes.view(),
                                                p.mesh.linear.elements.vertices[e], p.mesh.edges.of_elements[e]);
                const auto single = check_element(form, bound);
                RC_ASSERT(v.verdicts[e] == single.verdict);
                invalid += single.verdict == Verdict::invalid;
                undecided += single.verdict == Verdict::undecided;
                if (const Verdict positive = check_element(form, 0).verdict; positive != Verdict::valid)
                    not_positive.emplace_back(ElementId(e), positive);
                smallest = std::min(smallest, single.min_scaled_jacobian);
                // Both are lower bounds; that of the single element is close.
                RC_ASSERT(v.min_scaled_jacobian[e] <=
                          single.min_scaled_jacobian + scaled_jacobian_tolerance * std::max(1.0, std::abs(smallest)));
            }
            RC_ASSERT(v.invalid == invalid);
            RC_ASSERT(v.undecided == undecided);
            RC_ASSERT(v.not_positive == not_positive);
            RC_ASSERT(std::abs(v.smallest - smallest) <= scaled_jacobian_tolerance * std::max(1.0, std::abs(smallest)));
            RC_ASSERT(static_cast<double>(v.min_scaled_jacobian[v.worst]) == v.smallest);
        },
        {30});
}

template <int D>
void test_threads() {
    std::mt19937_64 random(7);
    const auto p = planned<D>(random, D == 2 ? 60 : 12, 0.25, 0.1);
    const auto one = validate(p.mesh, p.proposal, 1e-12, Execution{1}).value();
    const auto two = validate(p.mesh, p.proposal, 1e-12, Execution{2}).value();
    CHECK(one.validation().invalid > 0);
    CHECK(one == two);
}

}  // namespace

TEST_CASE("validate agrees with check_element on each element") {
    test_against_elements<2>();
    test_against_elements<3>();
}

TEST_CASE("validate does not depend on the number of threads") {
    test_threads<2>();
    test_threads<3>();
}

TEST_CASE("a straight mesh is valid with minimum scaled Jacobian 1") {
    std::mt19937_64 random(1);
    const auto p = planned<3>(random, 4, 0, 0);
    const auto v = validate(p.mesh, 1e-12, Execution{1}).value();
    CHECK(v.all_valid());
    CHECK(v.straight_inverted == 0);
    CHECK(v.smallest == doctest::Approx(1));
    CHECK(v.verdicts.size() == p.mesh.linear.elements.size());
}

TEST_CASE("an empty mesh is valid") {
    const auto empty = validate(QuadraticMesh<3>{}, 0, Execution{1}).value();
    CHECK(empty.all_valid());
    CHECK(empty.smallest == 1);
    CHECK_FALSE(empty.worst.valid());
}

TEST_CASE("validate rejects the proposal of another mesh") {
    std::mt19937_64 random(1);
    const auto p = planned<2>(random, 3, 0, 0);
    const auto foreign = validate(p.mesh, Proposal<2>{}, 0, Execution{1});
    REQUIRE_FALSE(foreign.has_value());
    CHECK(foreign.error().kind == ErrorKind::internal);
}

TEST_CASE("validate stops on request") {
    std::mt19937_64 random(1);
    const auto p = planned<2>(random, 3, 0, 0);
    std::stop_source source;
    source.request_stop();
    const auto halted = validate(p.mesh, 0, Execution{1, source.get_token()});
    REQUIRE_FALSE(halted.has_value());
    CHECK(halted.error().kind == ErrorKind::stopped);
}
