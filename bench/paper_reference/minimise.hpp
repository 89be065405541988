// Edge node of the paper: minimises the length on three points (§2.2.2) with BFGS from the middle of the chord.
#pragma once

#include <cstdint>

#include "back_field.hpp"
#include "edge.hpp"
#include "matrix.hpp"

namespace paper {

struct Options {
    Along along = Along::nodes;
    int max_iterations = 30;
    /// The search ends if the predicted or actual reduction of a step is below this share of the length.
    double tolerance = 1e-6;
};

struct Minimum {
    Vector node;
    double straight_length = 0;  ///< by the three points of the minimisation
    double length = 0;
    Work work;
};

/// Minimises with BFGS in physical coordinates and Armijo's rule. The first inverse Hessian is that of a constant
/// metric, in which the Hessian across the chord is 16 M/(3 length). Without it the condition number would be 10^12 at
/// anisotropy 10^6. Steps are limited to a quarter of the chord, for meshes that do not resolve their metric. Steps
/// that leave the mesh are shortened. The function does not allocate memory.
[[nodiscard]] Minimum minimise(const BackField& field, std::uint32_t a, std::uint32_t b, std::uint32_t hint,
                               const Options& options);

}  // namespace paper
