// Random operations, two and three dimensions: whatever is done, the mesh is one, and the domain's. Ten thousand of
// each kind, a table of what became of them: build/bin/laws.
#include <cstddef>
#include <cstdint>
#include <string>

#include "operation_runs.hpp"
#include "property.hpp"
#include "random_operations.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D, class Run>
void holds(const char* name, int count, const RunOptions& options, Run&& run) {
    Tally<D> tally;
    property(name, [&](std::uint64_t seed) { RC_ASSERT(run(seed, options, tally) == std::string()); },
             {.count = count});
    for (std::size_t k = 0; k < tally.rows.size(); ++k) {
        INFO("kind " << k << ": " << tally.rows[k].accepted);
        CHECK(tally.rows[k].accepted > 20);
    }
}

}  // namespace

TEST_CASE("random operations leave a sound mesh of the same domain") {
    holds<2>("operations, 2D", 200, {.steps = 300, .max_elements = 200}, run_operations<2>);
    holds<3>("operations, 3D", 150, {.steps = 400, .max_elements = 600}, run_operations<3>);
}

TEST_CASE("a star is sound by its topology alone") {
    const RunOptions options{.steps = 200, .max_elements = 300, .steps_a_check = 4};
    holds<2>("topology, 2D", 150, options, run_topology<2>);
    holds<3>("topology, 3D", 150, options, run_topology<3>);
    // Surfaces that came to be another one: pinched by a new point on two pieces of it, folded onto a line.
    Tally<3> tally;
    for (const std::uint64_t seed : {10430U, 1765U}) CHECK(run_topology<3>(seed, options, tally) == std::string());
}
