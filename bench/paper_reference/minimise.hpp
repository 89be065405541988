// The paper's node of an edge: the one whose edge is shortest on three points (§2.2.2), by BFGS from the chord's
// middle.
#pragma once

#include <cstdint>

#include "back_field.hpp"
#include "edge.hpp"
#include "matrix.hpp"

namespace paper {

struct Options {
    Along along = Along::nodes;
    int max_iterations = 30;
    /// The search ends when a step promises to shorten the edge, or did so, by less than this share.
    double tolerance = 1e-6;
};

struct Minimum {
    Vector node;
    double straight_length = 0;  ///< by the three points that were minimised on
    double length = 0;
    Work work;
};

/// BFGS in physical coordinates with Armijo's rule. The first inverse Hessian is that of a constant metric, in which
/// the Hessian across the chord is 16 M/(3 length): physical coordinates alone would have its condition, 10^12 at
/// anisotropy 10^6. No step is longer than a quarter of the chord, which matters where a mesh does not resolve its
/// metric. The node stays in the mesh: steps that lead out of it are shortened. No allocation.
[[nodiscard]] Minimum minimise(const BackField& field, std::uint32_t a, std::uint32_t b, std::uint32_t hint,
                               const Options& options);

}  // namespace paper
