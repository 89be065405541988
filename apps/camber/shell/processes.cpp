module;
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
module camber.app_shell;
import camber.core;
import :descriptor;

namespace camber::app {

namespace {

constexpr int handed_over = 3;  // descriptor to which the child writes

/// A child process that is killed with its owner.
class Child {
  public:
    explicit Child(pid_t pid) : pid_(pid) {}
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    Child(Child&&) = delete;
    Child& operator=(Child&&) = delete;
    ~Child() {
        if (pid_ < 0) return;
        kill(pid_, SIGKILL);
        (void)status();
    }

    [[nodiscard]] int status() {
        int status = 0;
        while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        pid_ = -1;
        return status;
    }

  private:
    pid_t pid_;
};

/// The module's only global setting, see `start_itself_by`.
std::vector<std::string>& own_words() {
    static std::vector<std::string> words{"/proc/self/exe"};
    return words;
}

/// Starts a program, found along PATH, after prepare(files, attributes). Returns an errno value, or 0 with `pid` set.
int start(std::vector<std::string> words, pid_t& pid, auto&& prepare) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    prepare(files, attributes);
    std::vector<char*> list;
    list.reserve(words.size() + 1);
    for (std::string& word : words) list.push_back(word.data());
    list.push_back(nullptr);
    const int error = posix_spawnp(&pid, list.front(), &files, &attributes, list.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

int spawn_self(const std::vector<std::string>& arguments, int pipe, pid_t& pid) {
    std::vector<std::string> words = own_words();
    words.insert(words.end(), arguments.begin(), arguments.end());
    return start(std::move(words), pid, [&](auto& files, auto&) {
        posix_spawn_file_actions_adddup2(&files, pipe, handed_over);
        for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
            posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
    });
}

std::string name_of_signal(int signal) {
    switch (signal) {
        case SIGSEGV: return "segmentation fault";
        case SIGABRT: return "abort";
        case SIGBUS: return "bus error";
        case SIGFPE: return "arithmetic error";
        case SIGKILL: return "killed";
        default: return "signal " + std::to_string(signal);
    }
}

/// "exit code 3", "segmentation fault"; empty: success.
std::string failure(int status) {
    if (WIFSIGNALED(status)) return name_of_signal(WTERMSIG(status));
    const int code = WEXITSTATUS(status);
    return code == 0 ? std::string() : "exit code " + std::to_string(code);
}

}  // namespace

void start_itself_by(std::vector<std::string> words) { own_words() = std::move(words); }
bool can_start_itself() { return !own_words().empty(); }

Outcome<ChildResult> run_self(const std::vector<std::string>& arguments, const ChildLimits& limits,
                              const Execution& execution) {
    using Clock = std::chrono::steady_clock;
    constexpr int tick = 50;  // ms between two checks of the clock and of the request to stop
    std::array<int, 2> pipe{};
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) return fail(ErrorKind::internal, "cannot create a pipe to another process");
    pid_t pid = -1;
    const int error = spawn_self(arguments, pipe[1], pid);
    close(pipe[1]);
    const Descriptor from_child(pipe[0]);
    Child child(error == 0 ? pid : -1);
    if (error != 0)
        return fail(ErrorKind::internal, "cannot start the program again (error " + std::to_string(error) + ")",
                    own_words().front());
    const auto until = Clock::now() + std::chrono::duration<double>(limits.seconds);
    std::string bytes;
    std::vector<char> part(1U << 16U);
    for (;;) {
        if (execution.stop.stop_requested()) return fail(ErrorKind::stopped, "stopped on request");
        if (Clock::now() > until) return ChildResult{ChildEnd::out_of_time, {}, {}};
        pollfd wait{from_child.get(), POLLIN, 0};
        if (poll(&wait, 1, tick) <= 0) continue;
        const ssize_t got = read(from_child.get(), part.data(), part.size());
        if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (got <= 0) break;
        bytes.append(part.data(), static_cast<std::size_t>(got));
    }
    const int status = child.status();
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return ChildResult{ChildEnd::out_of_time, {}, {}};
    if (std::string how = failure(status); !how.empty()) return ChildResult{ChildEnd::crashed, {}, std::move(how)};
    return ChildResult{ChildEnd::done, std::move(bytes), {}};
}

void set_limits(const ChildLimits& limits) {
    const auto set = [](auto resource, double limit) {
        const auto most = static_cast<rlim_t>(limit);
        const rlimit both{most, most};
        setrlimit(resource, &both);
    };
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    set(RLIMIT_CORE, 0);
    const auto seconds = static_cast<rlim_t>(std::ceil(limits.seconds));
    const rlimit processor{seconds, seconds + 1};
    setrlimit(RLIMIT_CPU, &processor);
#if !__has_feature(address_sanitizer)
    set(RLIMIT_AS, static_cast<double>(limits.bytes));
#endif
}

bool hand_over(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = write(handed_over, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds tick(20);  // between two checks of the process, the clock and the request to stop
constexpr std::chrono::seconds grace(2);       // between SIGTERM and SIGKILL

/// A process group, identified by its leader.
class Group {
  public:
    explicit Group(pid_t leader) : leader_(leader) {}
    Group(const Group&) = delete;
    Group& operator=(const Group&) = delete;
    Group(Group&&) = delete;
    Group& operator=(Group&&) = delete;
    ~Group() {
        if (!ended_) end();
    }

    [[nodiscard]] std::optional<int> status() {
        int status = 0;
        if (waitpid(leader_, &status, WNOHANG) != leader_) return std::nullopt;
        ended_ = true;
        return status;
    }

  private:
    void end() {
        kill(-leader_, SIGTERM);
        const auto until = Clock::now() + grace;
        while (!status() && Clock::now() < until) std::this_thread::sleep_for(tick);
        kill(-leader_, SIGKILL);  // also kills other processes of the group
        while (!ended_ && !status()) std::this_thread::sleep_for(tick);
    }

    pid_t leader_;
    bool ended_ = false;
};

int spawn(const std::vector<std::string>& words, const std::string& output, pid_t& pid) {
    return start(words, pid, [&](auto& files, auto& attributes) {
        posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
        posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
        sigset_t usual;
        sigemptyset(&usual);
        sigaddset(&usual, SIGPIPE);
        sigaddset(&usual, SIGXFSZ);
        posix_spawnattr_setsigdefault(&attributes, &usual);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    });
}

}  // namespace

Outcome<CommandResult> run_command_line(const std::vector<std::string>& words, double seconds,
                                        const std::string& output, const Execution& execution) {
    if (words.empty()) return fail(ErrorKind::internal, "the command has no words");
    if (auto writable = check_writable(output); !writable) return fail(writable.error());
    const auto begin = Clock::now();
    const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
    pid_t pid = -1;
    if (const int error = spawn(words, output, pid); error != 0)
        return fail(ErrorKind::usage, "cannot be started: " + std::generic_category().message(error), words.front(), {},
                    "check that the program exists and is on the PATH");
    Group group(pid);
    for (;;) {
        if (const auto status = group.status()) {
            std::string how = failure(*status);
            const CommandEnd end = how.empty() ? CommandEnd::done : CommandEnd::failed;
            return CommandResult{end, std::move(how), passed()};
        }
        if (execution.stop.stop_requested()) return fail(ErrorKind::stopped, "stopped on request");
        if (seconds > 0 && passed() > seconds) return CommandResult{CommandEnd::out_of_time, {}, passed()};
        std::this_thread::sleep_for(tick);
    }
}

namespace {

std::string& the_line() {
    static std::string line;
    return line;
}

}  // namespace

std::string shell_word(std::string_view word) {
    constexpr std::string_view plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-+=./:,@%";
    if (!word.empty() && word.find_first_not_of(plain) == std::string_view::npos) return std::string(word);
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}

void set_command_line(std::span<char*> arguments) {
    std::string line = "camber";
    for (std::size_t i = 1; i < arguments.size(); ++i) line += " " + shell_word(arguments[i]);
    the_line() = line;
}

const std::string& command_line() { return the_line(); }

namespace {

/// Never destroyed, because a signal can arrive at any time.
std::stop_source& source() {
    static auto* const only = new std::stop_source;
    return *only;
}

/// State of a name. The signal handler reads names at any time, so their memory is never freed.
enum class Place : std::uint8_t { free, taken, registered };
struct Name {
    std::atomic<Place> place = Place::free;
    std::array<char, PATH_MAX> path = {};
};
std::array<Name, 8> to_remove;

/// Safe in a signal handler: unlink is allowed, and without callbacks `request_stop` is one atomic exchange.
extern "C" void request_stop(int) {
    for (const Name& name : to_remove)
        if (name.place.load() == Place::registered) ::unlink(name.path.data());
    source().request_stop();
}

}  // namespace

std::stop_token stop_on_signals() {
    const std::stop_token token = source().get_token();  // created before any handler can run
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
        to_remove[i].place = Place::registered;
        place_ = i;
    }
}

RemovedOnSignals::~RemovedOnSignals() {
    if (place_) to_remove[*place_].place = Place::free;
}

namespace {

/// Default of Linux.
constexpr std::size_t usual_stack = std::size_t{8} << 20U;

bool has_usual_stack() {
    rlimit limit{};
    return ::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= usual_stack;
}

void set_default_thread_stacks() {
    pthread_attr_t attributes;
    if (::pthread_attr_init(&attributes) != 0) return;
    if (::pthread_attr_setstacksize(&attributes, usual_stack) == 0) (void)::pthread_setattr_default_np(&attributes);
    ::pthread_attr_destroy(&attributes);
}

}  // namespace

int with_usual_stack(const std::function<int()>& work) {
    if (has_usual_stack()) return work();
    set_default_thread_stacks();
    int code = 0;
    std::exception_ptr failure;
    const auto run = [&] {
        try {
            code = work();
        } catch (...) {
            failure = std::current_exception();
        }
    };
    try {
        std::thread(run).join();
    } catch (const std::system_error&) {  // no memory for a thread: the work may still succeed, or reports this
        return work();
    }
    if (failure) std::rethrow_exception(failure);
    return code;
}

}  // namespace camber::app
