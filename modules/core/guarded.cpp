module;
#include <cerrno>
#include <new>
#include <string>
#include <system_error>
module camber.core;
import :array_files;
import :guarded;
import :outcome;

namespace camber {

Error out_of_memory(const std::bad_alloc& failure) {
    const auto* const file = dynamic_cast<const NoFileForArray*>(&failure);
    if (file == nullptr)
        return {ErrorKind::memory, "not enough memory", {}, {}, "give it more memory, or a smaller mesh"};
    return {ErrorKind::write,
            "temporary files of arrays cannot be written: " + std::generic_category().message(file->error()),
            file->folder(),
            {},
            file->error() == EFBIG ? "raise the limit (ulimit -f)" : "make room, or take another place for the output"};
}

}  // namespace camber
