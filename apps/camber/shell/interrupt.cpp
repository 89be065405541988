module;
#include <csignal>
#include <stop_token>
module camber.app_shell;

namespace camber::app {

namespace {

/// Never destroyed: a signal may come at any time.
std::stop_source& source() {
    static auto* const only = new std::stop_source;
    return *only;
}

/// Sound in a handler as nobody registers callbacks on the token: then it is one atomic exchange.
extern "C" void request_stop(int) { source().request_stop(); }

}  // namespace

std::stop_token stop_on_signals() {
    const std::stop_token token = source().get_token();  // made before any handler can run
    struct sigaction once{};
    once.sa_handler = request_stop;
    once.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigemptyset(&once.sa_mask);
    sigaction(SIGINT, &once, nullptr);
    sigaction(SIGTERM, &once, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    return token;
}

}  // namespace camber::app
