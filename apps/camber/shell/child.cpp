module;
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.app_shell;
import camber.core;

namespace camber::app {

namespace {

constexpr int handed_over = 3;  // the descriptor that the child writes to

/// A child, which does not outlive its owner, and the end of the pipe from it.
class Child {
  public:
    Child(pid_t pid, int pipe) : pid_(pid), pipe_(pipe) {}
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    Child(Child&&) = delete;
    Child& operator=(Child&&) = delete;
    ~Child() {
        close(pipe_);
        if (pid_ < 0) return;
        kill(pid_, SIGKILL);
        (void)status();
    }

    [[nodiscard]] int pipe() const { return pipe_; }
    /// As waitpid gives it, when it has ended.
    [[nodiscard]] int status() {
        int status = 0;
        while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        pid_ = -1;
        return status;
    }

  private:
    pid_t pid_;
    int pipe_;
};

/// The shell's one setting of the process: see start_itself_by.
std::vector<std::string>& own_words() {
    static std::vector<std::string> words{"/proc/self/exe"};
    return words;
}

/// 0, and the child's number; else an error's.
int spawn_self(const std::vector<std::string>& arguments, int pipe, pid_t& pid) {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, pipe, handed_over);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
    std::vector<std::string> words = own_words();
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> list;
    list.reserve(words.size() + 1);
    for (std::string& word : words) list.push_back(word.data());
    list.push_back(nullptr);
    const int error = posix_spawn(&pid, own_words().front().c_str(), &files, nullptr, list.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

ChildResult ended(int status, std::string bytes) {
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        if (signal == SIGXCPU) return {ChildEnd::out_of_time, {}, {}};
        return {ChildEnd::crashed, {}, name_of_signal(signal)};
    }
    if (WEXITSTATUS(status) != 0) return {ChildEnd::crashed, {}, "exit code " + std::to_string(WEXITSTATUS(status))};
    return {ChildEnd::done, std::move(bytes), {}};
}

}  // namespace

void start_itself_by(std::vector<std::string> words) { own_words() = std::move(words); }
bool can_start_itself() { return !own_words().empty(); }

Outcome<ChildResult> run_self(const std::vector<std::string>& arguments, const ChildLimits& limits,
                              const Execution& execution) {
    using Clock = std::chrono::steady_clock;
    constexpr int tick = 50;  // ms, between looks at the clock and at the request to stop
    std::array<int, 2> pipe{};
    if (pipe2(pipe.data(), O_CLOEXEC) != 0) return fail(ErrorKind::internal, "no pipe to another process can be made");
    pid_t pid = -1;
    const int error = spawn_self(arguments, pipe[1], pid);
    close(pipe[1]);
    Child child(error == 0 ? pid : -1, pipe[0]);
    if (error != 0)
        return fail(ErrorKind::internal,
                    "the program cannot be started once more (error " + std::to_string(error) + ")",
                    own_words().front());
    const auto until = Clock::now() + std::chrono::duration<double>(limits.seconds);
    std::string bytes;
    std::vector<char> part(1U << 16U);
    for (;;) {
        if (execution.stop.stop_requested()) return fail(ErrorKind::stopped, "stopped on request");
        if (Clock::now() > until) return ChildResult{ChildEnd::out_of_time, {}, {}};
        pollfd wait{child.pipe(), POLLIN, 0};
        if (poll(&wait, 1, tick) <= 0) continue;
        const ssize_t got = read(child.pipe(), part.data(), part.size());
        if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (got <= 0) break;
        bytes.append(part.data(), static_cast<std::size_t>(got));
    }
    return ended(child.status(), std::move(bytes));
}

void keep_limits(const ChildLimits& limits) {
    const auto set = [](auto resource, double limit) {
        const auto most = static_cast<rlim_t>(limit);
        const rlimit both{most, most};
        setrlimit(resource, &both);
    };
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    set(RLIMIT_CORE, 0);
    const rlimit processor{static_cast<rlim_t>(std::ceil(limits.seconds)),
                           static_cast<rlim_t>(std::ceil(limits.seconds)) + 1};
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

}  // namespace camber::app
