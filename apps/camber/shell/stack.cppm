module;
#include <functional>
export module camber.app_shell:stack;

export namespace camber::app {

/// Returns work(). Where the stack of this process is smaller than usual (ulimit -s), the work runs on a thread with
/// one of the usual size, as all threads do that are made from then on.
[[nodiscard]] int with_usual_stack(const std::function<int()>& work);

}  // namespace camber::app
