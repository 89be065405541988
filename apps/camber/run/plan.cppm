module;
#include <cstddef>
#include <optional>
#include <string>
export module camber.run:plan;
import camber.config;
import camber.io;
import :memory;

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

/// What a run would do, for `--dry-run`: input and sizes, metric, geometry, each stage with the options that are not
/// the defaults, memory and time expected. `growth`: what passes will make, where that is known.
[[nodiscard]] std::string plan_text(const config::Pipeline& pipeline, const PlanSize& size,
                                    const std::optional<Growth>& growth, int threads);

}  // namespace camber::run
