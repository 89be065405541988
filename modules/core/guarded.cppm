module;
#include <new>
#include <stdexcept>
#include <string>
export module camber.core:guarded;
import :outcome;

export namespace camber {

/// Runs f() → Outcome at a module's face: memory or a thread that is not to be had becomes an error of kind memory.
/// Other exceptions are broken promises and pass.
template <class F>
[[nodiscard]] auto guarded(F&& f) -> decltype(f()) {
    constexpr const char* remedy = "give it more memory, or a smaller mesh";
    try {
        return f();
    } catch (const std::bad_alloc&) {
        return fail(ErrorKind::memory, "not enough memory", {}, {}, remedy);
    } catch (const std::length_error&) {
        return fail(ErrorKind::memory, "not enough memory", {}, {}, remedy);
    } catch (const std::runtime_error& error) {  // std::system_error, and what the thread library throws instead
        return fail(ErrorKind::memory, std::string("the system refuses: ") + error.what(), {}, {},
                    "use fewer threads: --threads 1");
    }
}

}  // namespace camber
