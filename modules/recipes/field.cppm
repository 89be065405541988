module;
#include <optional>
export module camber.recipes:field;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import :curve_input;
import :metric_source;

export namespace camber {

/// A metric as a field on the mesh itself, straight or with its curves. Errors: those of the source, stopped, memory.
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_field(const LinearMesh<D>& mesh, const MetricSource<D>& metric,
                                              const Execution& execution);
template <int D>
[[nodiscard]] Outcome<BackMesh<D>> make_field(const QuadraticMesh<D>& mesh, const MetricSource<D>& metric,
                                              const Execution& execution);

}  // namespace camber

namespace camber {

/// A field that edges are curved by, and where those of the volume begin.
template <int D>
struct CurvingField {
    BackMesh<D> back;
    std::optional<Column<LogMetric<D>>> straight;  ///< of the straight mesh, where the field is another
    Column<LagrangeNode<D>> nodes;                 ///< empty: chords
};

/// Carried along with walls that sag, where the input has an extension; else on the straight mesh.
template <int D>
[[nodiscard]] Outcome<CurvingField<D>> make_curving_field(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                                          const MetricSource<D>& metric, CurvingAim aim,
                                                          const Execution& execution);

}  // namespace camber
