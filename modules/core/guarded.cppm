module;
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
export module camber.core:guarded;
import :outcome;

export namespace camber {

/// Whether an exception says that there is no thread to be had: TBB tells it by a runtime_error of the call's name.
[[nodiscard]] inline bool tells_of_threads(const std::runtime_error& error) {
    return dynamic_cast<const std::system_error*>(&error) != nullptr ||
           std::string_view(error.what()).starts_with("pthread_");
}

/// The error of an allocation that failed. Of an array in a file it is the system's reason: a full disk, a limit of the
/// size of files (kind write).
[[nodiscard]] Error out_of_memory(const std::bad_alloc& failure);

/// Runs f() → Outcome at a module's face: memory or a thread that is not to be had becomes an error of kind memory.
/// Other exceptions are broken promises and pass.
template <class F>
[[nodiscard]] auto guarded(F&& f) -> decltype(f()) {
    try {
        return f();
    } catch (const std::bad_alloc& failure) {
        return fail(out_of_memory(failure));
    } catch (const std::length_error&) {
        return fail(out_of_memory(std::bad_alloc()));
    } catch (const std::runtime_error& error) {
        if (!tells_of_threads(error)) throw;
        return fail(ErrorKind::memory, std::string("the system refuses: ") + error.what(), {}, {},
                    "use fewer threads: --threads 1");
    }
}

}  // namespace camber
