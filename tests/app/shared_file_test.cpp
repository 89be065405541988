// Files that several processes read and write at given positions.
#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <span>
#include <string>
#include <system_error>

import camber.core;
import camber.app_shell;

using namespace camber;
using namespace camber::app;
namespace fs = std::filesystem;

namespace {

struct Folder {
    Folder() {
        std::string name = (fs::temp_directory_path() / "camber-test-XXXXXX").string();
        path = ::mkdtemp(name.data());
    }
    Folder(const Folder&) = delete;
    Folder(Folder&&) = delete;
    Folder& operator=(const Folder&) = delete;
    Folder& operator=(Folder&&) = delete;
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

std::string text_of(const std::string& path) {
    const auto bytes = read_file(path);
    return bytes ? std::string(as_text(*bytes)) : describe(bytes.error());
}

}  // namespace

TEST_CASE("a shared file appears under its name only after publish") {
    const Folder folder;
    const std::string path = folder / "mesh.meshb";
    auto first = SharedFile::make(path, 8);
    REQUIRE(first.has_value());
    {
        auto other = SharedFile::join(path, first->draft());
        REQUIRE(other.has_value());
        CHECK(other->write(5, as_bytes("xyz"), {}).has_value());
        CHECK(other->flush().has_value());
    }
    CHECK(first->write(0, as_bytes("abcde"), {}).has_value());
    CHECK_FALSE(fs::exists(path));
    CHECK(first->flush().has_value());
    CHECK(first->publish().has_value());
    CHECK(text_of(path) == "abcdexyz");
    CHECK(folder.files() == 1);
}

TEST_CASE("an abandoned shared file leaves no draft and does not change the old file") {
    const Folder folder;
    const std::string path = folder / "mesh.meshb";
    REQUIRE(write_file(path, std::array{as_bytes("old")}).has_value());
    REQUIRE(SharedFile::make(path, 8).has_value());
    CHECK(text_of(path) == "old");
    CHECK(folder.files() == 1);
}

TEST_CASE("a new shared file removes an older draft, whose publish then fails") {
    const Folder folder;
    const std::string path = folder / "mesh.meshb";
    auto killed = SharedFile::make(path, 8);
    REQUIRE(killed.has_value());
    auto next = SharedFile::make(path, 3);
    REQUIRE(next.has_value());
    CHECK(folder.files() == 1);
    CHECK(next->write(0, as_bytes("new"), {}).has_value());
    CHECK(killed->publish().error().kind == ErrorKind::write);
    CHECK(next->publish().has_value());
    CHECK(text_of(path) == "new");
}

TEST_CASE("a signal removes the draft of a shared file immediately") {
    const Folder folder;
    const std::string path = folder / "mesh.meshb";
    const pid_t child = ::fork();
    if (child == 0) {
        [[maybe_unused]] const auto stop = stop_on_signals();
        const auto file = SharedFile::make(path, 8);
        std::raise(SIGTERM);
        ::_exit(file && !fs::exists(file->draft()) ? 0 : 1);  // exits without calling its destructor
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    CHECK(folder.files() == 0);
}

TEST_CASE("shared files in a missing folder are a write error") {
    const Folder folder;
    CHECK(SharedFile::make(folder / "none/mesh.meshb", 8).error().kind == ErrorKind::write);
    CHECK(SharedFile::join(folder / "mesh.meshb", folder / "gone").error().kind == ErrorKind::write);
}

TEST_CASE("a mapped file has the content of the file after the file is removed") {
    const Folder folder;
    const std::string path = folder / "mesh.meshb";
    REQUIRE(write_file(path, std::array{as_bytes("some bytes")}).has_value());
    const auto bytes = map_file(path);
    REQUIRE(bytes.has_value());
    fs::remove(path);
    CHECK(as_text(bytes->view()) == "some bytes");
    REQUIRE(write_file(path, {}).has_value());
    CHECK(map_file(path)->empty());
    CHECK(describe(map_file(folder / "gone").error()).find("No such file") != std::string::npos);
    CHECK(map_file(folder.path.string()).error().kind == ErrorKind::input);
}
