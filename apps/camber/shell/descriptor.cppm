module;
#include <cerrno>
#include <string>
#include <utility>
#include <unistd.h>
module camber.app_shell:descriptor;
import camber.core;

namespace camber::app {

class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    [[nodiscard]] int get() const { return fd_; }
    [[nodiscard]] explicit operator bool() const { return fd_ >= 0; }
    /// Some file systems tell only now that they could not write.
    [[nodiscard]] bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

  private:
    int fd_;
};

/// `path: cannot be VERB: the system's reason (what the user can do about it)`.
[[nodiscard]] Error system_error(ErrorKind kind, const std::string& path, const char* verb, int error = errno);

/// What the path leads to after symbolic links, so that a link stays one.
[[nodiscard]] std::string target_of(const std::string& path);
[[nodiscard]] std::string folder_of(const std::string& path);
/// A name in the folder of another; not made from it, which may be as long as names can be.
[[nodiscard]] std::string beside(const std::string& path, const std::string& name);

}  // namespace camber::app
