#include <cstddef>
#include <cstdio>
#include <exception>
#include <new>
#include <span>

#include "program.hpp"
import camber.app_shell;
import camber.commands;
import camber.distributed;

int main(int argc, char** argv) {
    using namespace camber::app;
    protect_standard_streams();
    try {
        const std::span<char*> arguments(argv, static_cast<std::size_t>(argc));
        return with_usual_stack([&] {
            if (const auto code = cad_reader(arguments)) return *code;
            return run_program(arguments, camber::one_rank());
        });
    } catch (const std::bad_alloc&) {
        std::fputs("camber: not enough memory (use a machine with more memory, or a smaller mesh)\n", stderr);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "camber: internal error: %s\n", error.what());
    }
    return 4;
}
