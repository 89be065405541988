module;
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <string_view>
#include <system_error>
module camber.app_shell;
import camber.core;
import :voice;

namespace camber::app {

void hold_standard_streams() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    int fd = 0;  // the lowest that is free; opened for reading only, so that writing fails as on a closed one
    while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDONLY);
    if (fd > STDERR_FILENO) ::close(fd);
}

void StandardOutput::print(std::string_view text) {
    if (voice() == Voice::none) return;
    std::FILE* const to = fd_ == STDOUT_FILENO ? stdout : stderr;
    if (error_ == 0 && std::fwrite(text.data(), 1, text.size(), to) < text.size()) error_ = errno;
}

Outcome<Done> StandardOutput::finish() {
    if (error_ == 0 && std::fflush(fd_ == STDOUT_FILENO ? stdout : stderr) != 0) error_ = errno;
    if (error_ == 0 || error_ == EPIPE) return Done{};
    return fail(ErrorKind::write, "cannot be written: " + std::generic_category().message(error_), "standard output");
}

}  // namespace camber::app
