module;
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
export module camber.run:runner;
import camber.core;
import camber.config;
import camber.distributed;
import camber.metric;
import camber.cad;
import :geometry_source;
import :memory;
import :order;
import :parts;
import :report;
import :solution_source;
import :stages;
import :state;

namespace camber::run {

/// A value, and the seconds that it took.
template <class T>
struct Timed {
    T value;
    double seconds = 0;
};

/// The seconds of a recipe's steps, by name; of steps with one name the sum.
struct Clocks {
    std::map<std::string, double, std::less<>> seconds;
};

/// One run in D dimensions, as its stages see it: what the config says, the state that they take from and put into, the
/// shell's wrapper and clock, and the report, which can be told something but not be asked.
template <int D>
class Runner {
  public:
    Runner(const config::Pipeline& config, GivenMesh<D> mesh, std::span<const MetricFile> files,
           const SolutionSource* solution, GeometrySource geometry, AvailableMemory memory, const Around& around,
           std::shared_ptr<Ranks> ranks = one_rank(), RunEnd end = RunEnd::whole)
        : config(config),
          files(files),
          solution(solution),
          geometry(std::move(geometry)),
          memory(std::move(memory)),
          ranks(std::move(ranks)),
          end(end),
          state(beginning_with<D>(std::move(mesh))),
          around_(around) {}

    const config::Pipeline& config;
    const std::span<const MetricFile> files;  ///< all metric files that the config names
    const SolutionSource* const solution;     ///< null: no stage asks for it
    const GeometrySource geometry;
    const AvailableMemory memory;
    const std::shared_ptr<Ranks> ranks;  ///< who share what goes by blocks
    const RunEnd end;
    State<D> state;

    /// Of the state, which must be so far: `check_order` has seen that it is.
    [[nodiscard]] Quadratic<D>& quadratic() { return std::get<Quadratic<D>>(state.mesh); }
    [[nodiscard]] Plan<D>& plan() { return std::get<Plan<D>>(quadratic().plan); }
    [[nodiscard]] const BackMesh<D>* field() const { return state.field ? &*state.field : nullptr; }

    template <class F>
    auto step(std::string_view name, F&& f) {
        return run_step(around_, name, std::forward<F>(f));
    }
    /// The shell's wrapper for a recipe, with clocks.
    [[nodiscard]] Around around(Clocks& clocks) {
        return [this, &clocks](std::string_view name, const auto& body) {
            auto done = timed([&] { return around_(name, body); });
            clocks.seconds[std::string(name)] += done.seconds;
            return std::move(done.value);
        };
    }
    /// The step of the stage with these options.
    template <class Options, class F>
    auto step_of(const Options&, F&& f) {
        return step(std::get<StageRow<Options>>(stage_rows).name, std::forward<F>(f));
    }
    template <class F>
    static auto timed(F&& f) -> Timed<std::invoke_result_t<F>> {
        const auto begin = std::chrono::steady_clock::now();
        auto value = f();
        return {std::move(value), std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()};
    }

    void report(const auto& part) { add(report_, part); }
    [[nodiscard]] Report take_report() && { return std::move(report_); }

  private:
    const Around& around_;
    Report report_;
};

}  // namespace camber::run
