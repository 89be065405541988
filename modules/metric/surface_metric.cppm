module;
#include <optional>
#include <tuple>
export module camber.metric:surface_metric;
import camber.core;
import :spd;

export namespace camber {

/// The surface metric of paper §4.1: thin along the normal at the boundary, isotropic in the volume. Gradation then
/// carries it into the volume.
struct SurfaceMetricOptions {
    double tangent_size = 1;            ///< in the tangent plane: λ_min = tangent_size⁻²
    double normal_size = 0.1;           ///< along the normal: λ_max = normal_size⁻²; the paper takes a tenth
    std::optional<double> volume_size;  ///< at volume vertices (model units); as tangent_size unless given

    [[nodiscard]] static constexpr auto options() {
        using S = SurfaceMetricOptions;
        return std::tuple(
            option("tangent_size", &S::tangent_size, "size along the boundary").unit("model units").above(0).required(),
            option("normal_size", &S::normal_size, "size across it; a tenth of tangent_size curves well")
                .unit("model units")
                .above(0)
                .required());
    }
};

/// Unit normals at the vertices of a mesh: none in the volume, one a smooth side on the boundary, so two at a ridge and
/// more at a corner. Their orientation does not matter, nor does their order; a zero vector counts as none.
template <int D>
using VertexNormals = Incidence<Vec<D>>;

/// exp: R diag(λ_min, λ_min, λ_max) Rᵀ with the last axis along the normal. Where a vertex has several sides their
/// metrics are intersected, so that all normals are thin. Errors (usage): a size that is not positive; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> surface_log_metrics(const VertexNormals<D>& normals,
                                                                const SurfaceMetricOptions& options,
                                                                const Execution& execution);

}  // namespace camber
