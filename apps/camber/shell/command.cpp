module;
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>
module camber.app_shell;
import camber.core;

namespace camber::app {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds tick(20);  // between looks at it, at the clock and at the request to stop
constexpr std::chrono::seconds grace(2);       // from the asking to the killing

std::string system_reason(int error) { return std::generic_category().message(error); }

/// A process group by its leader, which is waited for.
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

    /// As waitpid gives it, once the leader has ended.
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
        kill(-leader_, SIGKILL);  // whoever of the group is left, too
        while (!ended_ && !status()) std::this_thread::sleep_for(tick);
    }

    pid_t leader_;
    bool ended_ = false;
};

/// 0, and the process's number; else an error's.
int spawn(const std::vector<std::string>& words, const std::string& output, pid_t& pid) {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    std::vector<std::string> copies = words;
    std::vector<char*> list;
    list.reserve(copies.size() + 1);
    for (std::string& word : copies) list.push_back(word.data());
    list.push_back(nullptr);
    const int error = posix_spawnp(&pid, list.front(), &files, &attributes, list.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

CommandResult ended(int status, double seconds) {
    if (WIFSIGNALED(status)) return {CommandEnd::failed, name_of_signal(WTERMSIG(status)), seconds};
    const int code = WEXITSTATUS(status);
    if (code == 0) return {CommandEnd::done, {}, seconds};
    return {CommandEnd::failed, "exit code " + std::to_string(code), seconds};
}

}  // namespace

Outcome<CommandResult> run_command_line(const std::vector<std::string>& words, double seconds,
                                        const std::string& output, const Execution& execution) {
    if (words.empty()) return fail(ErrorKind::internal, "a command of no words");
    if (auto writable = check_writable(output); !writable) return fail(writable.error());
    const auto begin = Clock::now();
    const auto passed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
    pid_t pid = -1;
    if (const int error = spawn(words, output, pid); error != 0)
        return fail(ErrorKind::usage, "cannot be started: " + system_reason(error), words.front(), {},
                    "give a program that is on the PATH, or its file");
    Group group(pid);
    for (;;) {
        if (const auto status = group.status()) return ended(*status, passed());
        if (execution.stop.stop_requested()) return fail(ErrorKind::stopped, "stopped on request");
        if (seconds > 0 && passed() > seconds) return CommandResult{CommandEnd::out_of_time, {}, passed()};
        std::this_thread::sleep_for(tick);
    }
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

}  // namespace camber::app
