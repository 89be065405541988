module;
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
export module camber.app_shell:shared_file;
import camber.core;

export namespace camber::app {

/// A file that several processes write to, each at its places, and that has its name when all have done so. Until then
/// it is a draft beside it, `.camber-….part`: the request to stop (interrupt.cppm) takes it away in whichever process,
/// and the next file of that name what a process left that was killed.
class SharedFile {
  public:
    /// By one of them: an empty draft of so many bytes. Errors: write.
    [[nodiscard]] static Outcome<SharedFile> make(const std::string& path, std::uint64_t bytes);
    /// By the others, on whichever machine: `draft` is the name that the first tells. Errors: write.
    [[nodiscard]] static Outcome<SharedFile> join(const std::string& path, const std::string& draft);

    SharedFile(SharedFile&&) noexcept;
    SharedFile& operator=(SharedFile&&) noexcept;
    SharedFile(const SharedFile&) = delete;
    SharedFile& operator=(const SharedFile&) = delete;
    /// The draft goes with the process that made it.
    ~SharedFile();

    [[nodiscard]] const std::string& draft() const;
    /// Errors: write, stopped.
    [[nodiscard]] Outcome<Done> write(std::uint64_t offset, std::span<const std::byte> bytes,
                                      const Execution& execution) const;
    /// What this process wrote is on disk. Errors: write.
    [[nodiscard]] Outcome<Done> flush() const;
    /// By the process that made it, once all have flushed: the draft has the file's name and the old one's permissions.
    /// Errors: write (also where somebody else has begun a file of the name).
    [[nodiscard]] Outcome<Done> publish();

  private:
    struct Open;
    explicit SharedFile(std::unique_ptr<Open> open);
    std::unique_ptr<Open> open_;
};

}  // namespace camber::app
