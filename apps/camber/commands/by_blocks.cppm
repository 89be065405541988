module camber.commands:by_blocks;
import camber.config;
import :given;

namespace camber::app {

/// Whether a pipeline goes by blocks: it says of how many elements, or several ranks share it.
[[nodiscard]] bool goes_by_blocks(const config::Pipeline& pipeline, const Host& host);

/// The whole run of a config by blocks, on all ranks of the host, with what is said at its end; its exit code. Of
/// several ranks each reads the rows of a binary .meshb that it works on, and writes its own at their offsets; what is
/// in another format is read as a whole.
[[nodiscard]] int finish_by_blocks(const config::Pipeline& pipeline, Host host);

}  // namespace camber::app
