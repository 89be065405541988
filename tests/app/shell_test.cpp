#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <limits>
#include <new>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

import camber.core;
import camber.app_shell;

using namespace camber;
using namespace camber::app;
namespace fs = std::filesystem;

namespace {

/// Temporary folder of one test case.
struct Folder {
    Folder() {
        std::string name = (fs::temp_directory_path() / "camber-test-XXXXXX").string();
        path = ::mkdtemp(name.data());
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    [[nodiscard]] std::string operator/(const char* name) const { return (path / name).string(); }
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), {}));
    }
    fs::path path;
};

Outcome<Done> write(const std::string& path, const std::vector<std::string>& texts) {
    std::vector<std::span<const std::byte>> chunks;
    for (const auto& text : texts) chunks.push_back(as_bytes(text));
    return write_file(path, chunks);
}

std::string text_of(const std::string& path) {
    const auto bytes = read_file(path);
    return bytes ? std::string(as_text(*bytes)) : describe(bytes.error());
}

}  // namespace

TEST_CASE("files written in chunks are read back for all sizes") {
    const Folder folder;
    for (const std::size_t size : {0U, 1U, 65535U, 65536U, 65537U, 300000U}) {
        std::string text(size, 'x');
        for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 2654435761U >> 24U);
        REQUIRE(write(folder / "a", {text.substr(0, size / 3), "", text.substr(size / 3)}).has_value());
        CHECK(text_of(folder / "a") == text);
    }
    CHECK(folder.files() == 1);
}

TEST_CASE("a bad path is an error of one line with the reason of the system") {
    const Folder folder;
    const std::string missing = folder / "missing";
    CHECK(text_of(missing) == missing + ": cannot be read: No such file or directory (check the path)");
    CHECK(text_of(folder.path.string()) == folder.path.string() + ": cannot be read: Is a directory (specify a file)");
    const std::string no_folder = folder / "no/such", nowhere = no_folder + "/place";
    const auto failed = write(nowhere, {"x"});
    REQUIRE_FALSE(failed.has_value());
    CHECK(failed.error().kind == ErrorKind::write);
    CHECK(describe(failed.error()) ==
          nowhere + ": its folder " + no_folder + " does not exist (create it: mkdir -p " + no_folder + ")");
    CHECK_FALSE(write(folder.path.string(), {"x"}).has_value());
    CHECK_FALSE(check_writable(nowhere).has_value());
    CHECK(check_writable(folder / "new").has_value());
    CHECK(folder.files() == 0);
}

TEST_CASE("replacing a file preserves permissions and symbolic links") {
    const Folder folder;
    REQUIRE(write(folder / "real", {"old"}).has_value());
    fs::permissions(folder / "real", fs::perms::owner_read | fs::perms::owner_write);
    fs::create_symlink("real", folder / "link");
    REQUIRE(write(folder / "link", {"new"}).has_value());
    CHECK(fs::is_symlink(folder / "link"));
    CHECK(text_of(folder / "real") == "new");
    CHECK(fs::status(folder / "real").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("a failed write preserves the old file and leaves no other file") {
    const Folder folder;
    REQUIRE(write(folder / "a", {"old"}).has_value());
    const pid_t child = ::fork();
    if (child == 0) {
        protect_standard_streams();
        const struct rlimit small{100000, 100000};
        ::setrlimit(RLIMIT_FSIZE, &small);
        const auto failed = write(folder / "a", {std::string(90000, 'x'), std::string(90000, 'y')});
        ::_exit(!failed && failed.error().what == "cannot be written: File too large" ? 0 : 1);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    CHECK(status == 0);
    CHECK(text_of(folder / "a") == "old");
    CHECK(folder.files() == 1);
}

TEST_CASE("devices are written directly") {
    CHECK(write("/dev/null", {"x"}).has_value());
    CHECK(describe(write("/dev/full", {"x"}).error()) ==
          "/dev/full: cannot be written: No space left on device (free disk space, or choose another path)");
}

TEST_CASE("the first signal requests a stop and the second ends the process") {
    const pid_t child = ::fork();
    if (child == 0) {
        const std::stop_token stop = stop_on_signals();
        if (stop.stop_requested()) ::_exit(1);
        ::raise(SIGINT);
        if (!stop.stop_requested()) ::_exit(2);
        ::raise(SIGINT);
        ::_exit(3);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == SIGINT);
}

TEST_CASE("a stop request ends reading and writing of a blocked pipe and prevents later writes") {
    const Folder folder;
    const std::string pipe = folder / "pipe";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    for (const bool reading : {true, false}) {
        std::stop_source source;
        ErrorKind kind = ErrorKind::internal;
        std::thread other([&] {
            if (reading) {
                const auto read = read_file(pipe, {.stop = source.get_token()});
                if (!read) kind = read.error().kind;
            } else {
                const auto bytes = as_bytes("x");
                const auto written = write_file(pipe, {&bytes, 1}, {.stop = source.get_token()});
                if (!written) kind = written.error().kind;
            }
        });
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        source.request_stop();
        other.join();
        CHECK(kind == ErrorKind::stopped);
    }
    std::stop_source stopped_before;
    stopped_before.request_stop();
    const auto bytes = as_bytes("x");
    const auto written = write_file(folder / "plain", {&bytes, 1}, {.stop = stopped_before.get_token()});
    REQUIRE_FALSE(written.has_value());
    CHECK(written.error().kind == ErrorKind::stopped);
    CHECK_FALSE(fs::exists(folder / "plain"));
}

TEST_CASE("a stream is read up to its bound and a plain file completely") {
    const Folder folder;
    const std::string pipe = folder / "pipe";
    REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
    protect_standard_streams();
    constexpr std::size_t bound = 100000;
    std::size_t size_of_beginning = 0;
    const StreamBound of_letters = [&](std::span<const std::byte> beginning) -> Outcome<std::size_t> {
        size_of_beginning = beginning.size();
        if (as_text(beginning).starts_with("x")) return bound;
        return fail(ErrorKind::input, "is no file of letters", "pipe");
    };
    for (const auto& [size, letter] : {std::pair{std::size_t{0}, 'x'}, std::pair{std::size_t{7}, 'x'},
                                       std::pair{bound, 'x'}, std::pair{bound + 1, 'x'}, std::pair{50 * bound, 'x'},
                                       std::pair{std::size_t{7}, 'y'}, std::pair{50 * bound, 'y'}}) {
        CAPTURE(size);
        const std::string text(size, letter);
        std::thread writer([&] { (void)write(pipe, {text}); });
        const auto read = read_file(pipe, {}, of_letters);
        writer.join();
        CHECK(read.has_value() == (letter == 'x' && size > 0 && size <= bound));
        CHECK(size_of_beginning <= beginning_of_stream);
        if (read) CHECK(as_text(*read) == text);
        if (!read && letter == 'x' && size > 0)
            CHECK(describe(read.error()) ==
                  pipe + ": is a stream of more than 0.1 MiB, the limit for streams (use a regular file)");
        if (!read && letter == 'y') CHECK(read.error().what == "is no file of letters");
        REQUIRE(write(folder / "plain", {text}).has_value());
        CHECK(text_of(folder / "plain") == text);
        CHECK(read_file(folder / "plain", {}, of_letters).has_value());
    }
    CHECK(describe(read_file("/dev/zero").error()) ==
          "/dev/zero: is a stream of more than 64.0 MiB, the limit for streams (use a regular file)");
}

TEST_CASE("with_usual_stack runs work on a large stack in a process with a small one") {
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit small{64 << 10, 64 << 10};
        ::setrlimit(RLIMIT_STACK, &small);
        const auto touch = [] {
            volatile char large[std::size_t{6} << 20U];
            large[0] = 1;
            large[sizeof(large) - 1] = 1;
            return large[0] - large[sizeof(large) - 1];
        };
        int on_thread = 1;
        const int code = with_usual_stack([&] {
            std::thread([&] { on_thread = touch(); }).join();
            return touch();
        });
        bool passes = false;
        try {
            (void)with_usual_stack([]() -> int { throw std::bad_alloc(); });
        } catch (const std::bad_alloc&) {
            passes = true;
        }
        ::_exit(code == 0 && on_thread == 0 && passes ? 0 : 1);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    CHECK(status == 0);
}

TEST_CASE("the memory limit is the minimum over a control group and its parents") {
    const Folder folder;
    const std::size_t none = std::numeric_limits<std::size_t>::max();
    const std::string root = folder.path.string();
    const auto limit = [&](const std::string& at, const std::string& text) {
        fs::create_directories(folder.path / at);
        REQUIRE(write((folder.path / at / "memory.max").string(), {text}).has_value());
    };
    CHECK(cgroup_limit(root, "/a/b", "memory.max") == none);
    limit("a/b", "max\n");
    CHECK(cgroup_limit(root, "/a/b", "memory.max") == none);
    limit("a", "5000\n");
    CHECK(cgroup_limit(root, "/a/b", "memory.max") == 5000U);
    limit("a/b", "7000\n");
    CHECK(cgroup_limit(root, "/a/b", "memory.max") == 5000U);
    limit(".", "3000\n");
    CHECK(cgroup_limit(root, "/a/b", "memory.max") == 3000U);
    CHECK(cgroup_limit(root, "/", "memory.max") == 3000U);
    CHECK(memory_limit().bytes > 0);
    CHECK(readable(std::size_t{3} << 29U) == "1.5 GiB");
    CHECK(readable(std::size_t{1} << 19U) == "0.5 MiB");
}

TEST_CASE("a meter measures elapsed time and peak memory") {
    const Meter meter;
    const auto before = meter.read();
    std::vector<char> memory(64U << 20U, 1);
    for (volatile char& c : memory) c = 2;  // prevents the compiler from removing the allocation
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const auto after = meter.read();
    CHECK(after.seconds >= before.seconds + 0.02);
    CHECK(after.peak_bytes >= memory.size());
}

TEST_CASE("file names of up to 255 bytes are written") {
    const Folder folder;
    for (const std::size_t length : {251U, 255U}) {
        const std::string path = folder / std::string(length, 'n').c_str();
        const auto written = write(path, {"x"});
        CHECK_MESSAGE(written.has_value(), (written ? std::string() : describe(written.error())));
        CHECK(text_of(path) == "x");
    }
    CHECK(folder.files() == 2);
}

TEST_CASE("the progress line shows share, rate and remaining time") {
    const auto line = [](double part, double left) { return progress_line("curve", {part, left}); };
    CHECK(line(0.5, 10) == "curve      [###############               ]  50 %  10 s left");
    CHECK(progress_line("curve", {0.5, 10, 1.26e6}).ends_with("]  50 %  1.3 M elements/s  10 s left"));
    CHECK(progress_line("curve", {0.5, 10, 26900}).ends_with("]  50 %  27 k elements/s  10 s left"));
    CHECK(line(0, -1).ends_with("]   0 %"));
    CHECK(line(0.99, 0).ends_with("]  99 %"));
}

// Guards against progress of repeated passes that decreases.
TEST_CASE("the share of repeated steps increases and stays below 1") {
    RoundsShare share;
    double before = 0;
    for (const std::size_t steps : {5, 4, 7, 5, 5, 1, 5}) {
        for (std::size_t k = 0; k < steps; ++k) {
            share.begin("step " + std::to_string(k));
            for (const double part : {0.0, 0.5, 0.2, 1.0}) {
                const double now = share.tick(part);
                CHECK(now >= before);
                CHECK(now < 1);
                before = now;
            }
        }
    }
    CHECK(share.round() == 7);
    CHECK(before > 0.98);
}

TEST_CASE("the remaining time of a stage at a constant rate is exact") {
    StageShare share;
    for (std::size_t done = 5; done < 100; done += 5) {
        const Share current = share.tick(done, 100, 0.1 * static_cast<double>(done));
        CHECK(current.part == doctest::Approx(0.01 * static_cast<double>(done)));
        CHECK(current.seconds_left == doctest::Approx(10 - 0.1 * static_cast<double>(done)));
    }
}

TEST_CASE("the share of a stage never decreases, stays below 1 and gives no remaining time at first") {
    StageShare share;
    CHECK(share.tick(1, 1000, 1).seconds_left < 0);
    double before = 0;
    for (const std::size_t done : {100U, 300U, 200U, 1000U, 0U, 1000U}) {
        const Share current = share.tick(done, 1000, 2);
        CHECK(current.part >= before);
        CHECK(current.part < 1);
        CHECK(current.seconds_left > 0);
        before = current.part;
    }
    CHECK(share.tick(0, 0, 3).part == before);
}

TEST_CASE("text is wrapped between words and examples are not wrapped") {
    CHECK(wrapped("one two three four", 9) == "one two\nthree\nfour");
    CHECK(wrapped("one two three", 9, 4) == "one\n    two\n    three");
    CHECK(wrapped("one\n\n  an example that is long\ntwo", 9) == "one\n\n  an example that is long\ntwo");
    CHECK(wrapped("alongwordindeed x", 9) == "alongwordindeed\nx");
    CHECK(wrapped("", 9).empty());
    CHECK(text_width() >= 60);
    CHECK(text_width() <= 100);
}

TEST_CASE("a command gets its arguments unchanged and its output is stored") {
    const Folder folder;
    const auto done =
        run_command_line({"sh", "-c", "echo \"$0|$1\"; echo err >&2", "a b", "$HOME;*"}, 0, folder / "said", {});
    REQUIRE(done);
    CHECK(done->end == CommandEnd::done);
    CHECK(text_of(folder / "said") == "a b|$HOME;*\nerr\n");
}

TEST_CASE("the exit code or signal of a failed command is reported") {
    const Folder folder;
    const auto code = run_command_line({"sh", "-c", "exit 3"}, 0, folder / "said", {});
    REQUIRE(code);
    CHECK(code->end == CommandEnd::failed);
    CHECK(code->how == "exit code 3");
    const auto signalled = run_command_line({"sh", "-c", "kill -SEGV $$"}, 0, folder / "said", {});
    REQUIRE(signalled);
    CHECK(signalled->how == "segmentation fault");
    const auto missing = run_command_line({"/no/such/solver"}, 0, folder / "said", {});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().kind == ErrorKind::usage);
}

TEST_CASE("a timeout or a stop request ends the process group of a command") {
    const Folder folder;
    const std::string wait = "(sleep 60 & echo $! > " + (folder / "pid") + "; wait)";
    const auto is_gone = [&] {
        const auto pid = static_cast<pid_t>(std::stol(text_of(folder / "pid")));
        for (int i = 0; i < 100 && ::kill(pid, 0) == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return ::kill(pid, 0) != 0;
    };
    const auto late = run_command_line({"sh", "-c", wait}, 0.3, folder / "said", {});
    REQUIRE(late);
    CHECK(late->end == CommandEnd::out_of_time);
    CHECK(is_gone());
    std::stop_source source;
    std::thread stopper([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        source.request_stop();
    });
    const auto stopped = run_command_line({"sh", "-c", wait}, 0, folder / "said", {.stop = source.get_token()});
    stopper.join();
    REQUIRE_FALSE(stopped);
    CHECK(stopped.error().kind == ErrorKind::stopped);
    CHECK(is_gone());
}
