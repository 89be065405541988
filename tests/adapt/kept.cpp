// Twenty rounds of all passes, to metrics that are coarser and finer in turn: materials, surfaces, ridges, corners,
// rims and what is required are kept. Larger meshes, and a table: build/bin/laws_of_passes.
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
void expect_kept(NamedDomain<D> domain) {
    const std::string name = domain.name;
    INFO(name << " in " << D << "D");
    ManyRounds<D> rounds(std::move(domain), 1, alone);
    std::size_t done = 0;
    for (int k = 0; k < less_if_sanitized(20, 4); ++k) {
        Round round;
        REQUIRE(rounds.run(size_of_round(k), round) == std::string());
        for (const PassStatistics& pass : round.passes) done += pass.accepted;
    }
    CHECK(done > 100);
}

}  // namespace

TEST_CASE("twenty rounds keep a domain of two dimensions") {
    for (NamedDomain<2>& domain : named_domains<2>(8)) expect_kept(std::move(domain));
}
TEST_CASE("twenty rounds keep a domain of three dimensions") {
    for (NamedDomain<3>& domain : named_domains<3>(4)) expect_kept(std::move(domain));
}
