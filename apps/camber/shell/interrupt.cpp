module;
#include <unistd.h>

#include <array>
#include <atomic>
#include <climits>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stop_token>
#include <string_view>
module camber.app_shell;

namespace camber::app {

namespace {

/// Never destroyed: a signal may come at any time.
std::stop_source& source() {
    static auto* const only = new std::stop_source;
    return *only;
}

/// Names that a handler may read whenever it comes: in memory that is never given back.
enum class Place : std::uint8_t { free, taken, told };
struct Name {
    std::atomic<Place> place = Place::free;
    std::array<char, PATH_MAX> path = {};
};
std::array<Name, 8> to_remove;

/// Sound in a handler as nobody registers callbacks on the token: then it is one atomic exchange. The system allows
/// unlink.
extern "C" void request_stop(int) {
    for (const Name& name : to_remove)
        if (name.place.load() == Place::told) ::unlink(name.path.data());
    source().request_stop();
}

}  // namespace

std::stop_token stop_on_signals() {
    const std::stop_token token = source().get_token();  // made before any handler can run
    struct sigaction once{};
    once.sa_handler = request_stop;
    once.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
    sigemptyset(&once.sa_mask);
    sigaction(SIGINT, &once, nullptr);
    sigaction(SIGTERM, &once, nullptr);
    return token;
}

RemovedOnSignals::RemovedOnSignals(std::string_view path) {
    if (path.size() >= PATH_MAX) return;
    for (std::size_t i = 0; i < to_remove.size() && !place_; ++i) {
        Place free = Place::free;
        if (!to_remove[i].place.compare_exchange_strong(free, Place::taken)) continue;
        std::memcpy(to_remove[i].path.data(), path.data(), path.size());
        to_remove[i].path[path.size()] = '\0';
        to_remove[i].place = Place::told;
        place_ = i;
    }
}

RemovedOnSignals::~RemovedOnSignals() {
    if (place_) to_remove[*place_].place = Place::free;
}

}  // namespace camber::app
