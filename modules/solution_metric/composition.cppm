module;
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <tuple>
export module camber.solution_metric:composition;
import camber.core;
import camber.metric;
import :local_model;
import :optimal_metric;

export namespace camber {

/// What is to be so many.
enum class AmountOf : std::uint8_t {
    complexity,  ///< ∫ sqrt det M
    vertices,    ///< of a mesh of unit elements
    elements,
};
[[nodiscard]] constexpr auto words(AmountOf) {
    return words_of(Word{AmountOf::complexity, "complexity"}, Word{AmountOf::vertices, "vertices"},
                    Word{AmountOf::elements, "elements"});
}

/// Elements of a mesh that was brought to a metric of complexity 1, as found (2.4 to 2.8 triangles, 12 to 15
/// tetrahedra: bench/results/solution-metrics.md). Regular simplices of side 1 would be 4/√3 and 6√2, but
/// tetrahedra do not fill space with these, and edges of a mesh are of unit length in the mean.
template <int D>
[[nodiscard]] constexpr double elements_per_complexity() {
    return D == 2 ? 2.6 : 12.5;
}
/// Elements for each vertex of a large mesh: of triangles 2 (Euler), of tetrahedra 5.7 (as found in remeshed meshes).
template <int D>
[[nodiscard]] constexpr double elements_per_vertex() {
    return D == 2 ? 2 : 5.7;
}
/// The complexity of a mesh of so many vertices or elements.
template <int D>
[[nodiscard]] inline double complexity_of(double amount, AmountOf of) {
    const double elements = of == AmountOf::vertices ? amount * elements_per_vertex<D>() : amount;
    return of == AmountOf::complexity ? amount : elements / elements_per_complexity<D>();
}

/// A field that the mesh is to be good for: its models at the vertices, and in which norm.
template <int D>
struct SolutionField {
    Column<LocalModel<D>> models;
    NormOptions norm = {};
    double share = 1;  ///< of the complexity, for its metric before fields are intersected; 0 to 1
};

struct SolutionMetricOptions {
    double amount = 0;
    AmountOf of = AmountOf::complexity;
    double min_size = 0;
    double max_size = 0;        ///< 0: the domain's diameter
    double max_anisotropy = 0;  ///< 0: none
    std::optional<GradationOptions> gradation = {};
    double tolerance = 1e-3;  ///< of the complexity, relative
    int max_evaluations = 12;

    [[nodiscard]] static constexpr auto options() {
        using S = SolutionMetricOptions;
        return std::tuple(
            option("amount", &S::amount, "how fine the mesh is to be").above(0).required(),
            option("of", &S::of, "what the amount is of: complexity, vertices, elements"),
            option("min_size", &S::min_size, "smallest size; 0: none").unit("model units").at_least(0),
            option("max_size", &S::max_size, "largest size; 0: the domain's diameter").unit("model units").at_least(0),
            option("max_anisotropy", &S::max_anisotropy, "largest ratio of sizes; 0: none").at_least(0),
            option("tolerance", &S::tolerance, "relative, of the complexity").at_least(1e-8).at_most(0.5),
            option("max_evaluations", &S::max_evaluations, "largest number of complexities that are tried")
                .at_least(1)
                .at_most(1000));
    }
};

/// The metric, and how it came about.
template <int D>
struct SolutionMetric {
    Column<LogMetric<D>> log_metrics;  ///< one a vertex
    double asked = 0, reached = 0;     ///< complexities
    double of_fixed = 0;               ///< complexity of all but the fields: fixed metrics, largest size, gradation
    /// The fixed part alone has the complexity asked for, or more: `log_metrics` is that part, and fields have no say.
    bool is_fixed_alone = false;
    bool is_reached = false;        ///< within the tolerance
    bool is_graded = true;          ///< false: a gradation ended before its time
    int evaluations = 0;            ///< complexities tried, those of gradations too
    int gradations = 0;             ///< that were done
    double at_min = 0, at_max = 0;  ///< shares of the vertices with a size at the smallest, and at the largest
};

/// A metric for one or more fields, of a complexity N, in this order:
///
///  1. each field's optimal metric (`optimal_metric`) with its share of N,
///  2. intersected with one another,
///  3. with `fixed` (one a vertex, `fixed_metric`; empty: none), and within the bounds,
///  4. graded;
///
/// and the fields' part is scaled (all their scales s by the same −t) until what comes out of 4. has complexity N, by
/// the secant on logarithms: what is fixed stays. The search begins where the metric before gradation has N, so that
/// few gradations are needed. Errors: those of `optimal_metric` and `apply_gradation`, models and metrics that are not
/// of this mesh, limits of options, no field (usage); stopped.
template <int D>
[[nodiscard]] Outcome<SolutionMetric<D>> make_solution_metric(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              std::span<const SolutionField<D>> fields,
                                                              const Column<LogMetric<D>>& fixed,
                                                              const SolutionMetricOptions& options,
                                                              const Execution& execution);

}  // namespace camber
