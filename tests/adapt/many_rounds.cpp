// Twenty rounds of all passes, to coarser and finer metrics in turn, preserve materials, surfaces, ridges, corners,
// rims and required entities. build/bin/pass_invariants runs larger meshes and prints a table.
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "many_rounds.hpp"
#include "meshes.hpp"
#include "named_domains.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.cavity;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void expect_preserved(NamedDomain<D> domain) {
    const std::string name = domain.name;
    INFO(name << " in " << D << "D");
    ManyRounds<D> rounds(std::move(domain), 1, one_thread);
    std::size_t accepted_operations = 0;
    for (int k = 0; k < less_if_sanitized(20, 4); ++k) {
        Round round;
        REQUIRE(rounds.run(size_of_round(k), round) == std::string());
        for (const PassStatistics& pass : round.passes) accepted_operations += pass.accepted;
    }
    CHECK(accepted_operations > 100);
}

}  // namespace

TEST_CASE("twenty rounds of passes preserve the domain and its features, 2D") {
    for (NamedDomain<2>& domain : named_domains<2>(8)) expect_preserved(std::move(domain));
}
TEST_CASE("twenty rounds of passes preserve the domain and its features, 3D") {
    for (NamedDomain<3>& domain : named_domains<3>(4)) expect_preserved(std::move(domain));
}
