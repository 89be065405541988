module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.recipes:metric_of_solution;
import camber.core;
import camber.recovery;
import camber.metric;
import camber.operation;
import camber.solution_metric;
import :geometry_sizes;

export namespace camber {

/// Error that is expected of a solution's interpolant, as ExpectedErrors: of one field weight · L2 error in the user's
/// unit, of several the root of Σ (weight · L2 error)², each in a unit in which its range is about 1.
struct ExpectedError {
    double l2 = 0;                     ///< 0: not known
    std::vector<double> weights = {};  ///< a field each; none: 1 of all
    friend bool operator==(const ExpectedError&, const ExpectedError&) = default;
};

struct MetricOfSolutionOptions {
    RecoveryOptions recovery = {};
    ModelOptions models = {};
    NormOptions norm = {};
    SolutionMetricOptions metric = {};      ///< an amount of 0: as many elements as the mesh has
    std::vector<ReferenceSize> sizes = {};  ///< that are asked for by reference
    GeometrySizes geometry = {};            ///< that the boundary's own surface asks for
    double ridge_angle = 40;                ///< beyond which the boundary breaks there (degrees)
    ExpectedError expected = {};            ///< of a mesh like the one to be made; see `bounds`
};

/// The metric, and what it was made of.
template <int D>
struct MetricOfSolution {
    SolutionMetric<D> metric;
    std::size_t rows = 0, from_inner_fits = 0,
                lower_degree = 0;  ///< of recovered derivatives, see RecoveredDerivatives
    std::size_t zero_models = 0, floored_models = 0;
    /// Largest distances of the boundary and of interfaces from their geometry, by reference: a boundary as far off
    /// changes the solution by no more than the expected error in L2. None where the error is not known, or the
    /// solution has no derivative along the normals.
    std::vector<DistanceBound> bounds = {};
};

/// The metric of the mesh that interpolates a solution best with elements of degree norm.degree, in the norm, for a
/// complexity. Each field is a column of values at the nodes: at the vertices (degree 1), or at those and the edges'
/// nodes (degree 2), which third derivatives need; each has the same share. Derivatives are one-sided by material.
/// Where the mesh is curved, or has materials, models are those of elements, and see what curves take away of the
/// error; else those of vertices. `given` metrics, one a vertex each, are fixed, as sizes and the geometry's are.
/// Steps: recover, models, fixed, metric. Docs: docs/algorithms/metric-from-solution.md. Errors: those of
/// `recover_derivatives`, `make_solution_metric`; elements of degree 2 for a field of degree 1 (usage); stopped,
/// memory.
template <int D>
[[nodiscard]] Outcome<MetricOfSolution<D>> metric_of_solution(const QuadraticMesh<D>& mesh,
                                                              std::span<const Column<double>> fields,
                                                              std::span<const Column<LogMetric<D>>> given,
                                                              const MetricOfSolutionOptions& options,
                                                              const Around& around);

}  // namespace camber
