// Random operations in 2D and 3D preserve the mesh and its domain. build/bin/invariants runs ten thousand of each kind
// and prints a table of outcomes.
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
void check_runs(const char* name, int count, const RunOptions& options, Run&& run) {
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
    check_runs<2>("random operations preserve all invariants, 2D", 200, {.steps = 300, .max_elements = 200},
                  run_operations<2>);
    check_runs<3>("random operations preserve all invariants, 3D", 150, {.steps = 400, .max_elements = 600},
                  run_operations<3>);
}

TEST_CASE("random operations checked by topology alone leave a sound mesh") {
    const RunOptions options{.steps = 200, .max_elements = 300, .steps_a_check = 4};
    check_runs<2>("operations checked by topology alone leave a sound mesh, 2D", 150, options, run_topology<2>);
    check_runs<3>("operations checked by topology alone leave a sound mesh, 3D", 150, options, run_topology<3>);
    // Guards against surfaces that are pinched by a new point on two pieces, or folded onto a line.
    Tally<3> tally;
    for (const std::uint64_t seed : {10430U, 1765U}) CHECK(run_topology<3>(seed, options, tally) == std::string());
}
