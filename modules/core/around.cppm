module;
#include <functional>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
export module camber.core:around;
import :execution;
import :guarded;
import :outcome;

export namespace camber {

/// A wrapper around each step of work that has several, with which a caller keeps clocks and shows progress:
/// `around(name, body)` must call body once, with the Execution to use.
using Around =
    std::function<Outcome<Done>(std::string_view step, const std::function<Outcome<Done>(const Execution&)>& body)>;

/// Steps with that execution, and nothing around them.
[[nodiscard]] inline Around plainly(const Execution& execution) {
    return [&execution](std::string_view, const auto& body) { return body(execution); };
}

/// f(execution) → Outcome as the step of that name; at its end the whole is told.
template <class F>
std::invoke_result_t<F, const Execution&> run_step(const Around& around, std::string_view name, F&& f) {
    std::optional<std::invoke_result_t<F, const Execution&>> made;
    const auto done = around(name, [&](const Execution& execution) -> Outcome<Done> {
        made = guarded([&] { return f(execution); });
        if (!*made) return fail(made->error());
        report_progress(execution, 1, 1);
        return Done{};
    });
    if (!done) return fail(done.error());
    return std::move(*made);
}

}  // namespace camber
