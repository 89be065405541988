module;
#include <cstddef>
#include <optional>
#include <string>
export module camber.run:plan;
import camber.config;
import camber.io;
import :memory;
import :report;

export namespace camber::run {

/// How large a run is before anything was done.
struct PlanSize {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, elements = 0, facets = 0;
    std::size_t edges = 0;       ///< estimated by Euler's formula from the others, exact for a ball
    std::size_t peak_bytes = 0;  ///< estimated_peak_bytes
};
[[nodiscard]] PlanSize plan_size(const AnyMesh& mesh);

/// "seconds", "minutes" or "hours": by 5 000 to 30 000 edges a second and thread.
[[nodiscard]] std::string time_class(const PlanSize& size, int threads);

/// The pipeline with a small share of the work of its repair, which is run to see how long the whole one takes. Nothing
/// where no stage repairs by optimisation, where passes change the mesh, and for meshes on which even that takes long.
[[nodiscard]] std::optional<config::Pipeline> probe_of(const config::Pipeline& pipeline, const PlanSize& size,
                                                       int threads);

/// The expected time of a run, in seconds. `seconds`: time of its probe; `probe`: what that reports. Repair that spent
/// its share of work in the probe is expected to spend all of it.
[[nodiscard]] double expected_seconds(const config::Pipeline& pipeline, const Report& probe, double seconds,
                                      int threads);

/// What a run would do, for `--dry-run`: input and sizes, metric, geometry, each stage with the options that are not
/// the defaults, memory and time expected. `growth`: what passes will make, where that is known. `seconds`: the time
/// that a probe predicts, if there was one.
[[nodiscard]] std::string plan_text(const config::Pipeline& pipeline, const PlanSize& size,
                                    const std::optional<Growth>& growth, std::optional<double> seconds, int threads);

}  // namespace camber::run
