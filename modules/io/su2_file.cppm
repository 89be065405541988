module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io:su2_file;
import camber.core;
import :text;

/// Where an SU2 file has what.
namespace camber::su2 {

inline constexpr const char* damaged = "the file is cut off or damaged";

[[nodiscard]] inline std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The lines of a text that say something, without comments (% to the end of the line) and blanks at their ends.
class Lines {
  public:
    explicit Lines(std::string_view text) : rest_(text) {}

    /// The next; none at the end.
    std::optional<std::string_view> next() {
        while (!rest_.empty()) {
            const std::size_t end = rest_.find('\n');
            std::string_view line = rest_.substr(0, end);
            ended_ = end != std::string_view::npos;
            rest_.remove_prefix(ended_ ? end + 1 : rest_.size());
            line = line.substr(0, line.find('%'));
            while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
            while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
            if (!line.empty()) return line;
        }
        return std::nullopt;
    }
    [[nodiscard]] std::size_t left() const { return rest_.size(); }
    [[nodiscard]] bool ended() const { return ended_; }  ///< the last line by a line break

  private:
    std::string_view rest_;
    bool ended_ = true;
};

/// `KEY= value`; no key: a row.
struct Entry {
    std::string_view key = {}, value = {};
};
[[nodiscard]] inline Entry entry_of(std::string_view line) {
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) return {};
    Words key{line.data(), line.data() + equals}, value{line.data() + equals + 1, line.data() + line.size()};
    const std::string_view name = key.next();
    if (name != "MARKER_TAG") return {name, value.next()};
    // A name is the rest of the line, whatever is in it.
    std::string_view rest = line.substr(equals + 1);
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    return {name, rest};
}

/// Rows that follow a keyword. Nothing of them has been looked at.
struct Block {
    std::size_t count = 0;
    Lines rows{{}};
    std::string tag = {};  ///< of a marker
};

/// What a zone of a file holds, block by block. A file without zones is one.
struct Zone {
    std::string name;  ///< the file's
    std::string_view text;
    std::optional<std::int64_t> dimension = {}, markers_announced = {};
    std::optional<Block> elements = {}, points = {};
    std::vector<Block> markers = {};
    std::int64_t number = 1;
    std::size_t parallel_markers = 0, foreign_blocks = 0;
    std::string first_foreign = {};

    [[nodiscard]] bool empty() const { return !dimension && !elements && !points && markers.empty(); }
    [[nodiscard]] std::string place(std::string_view at) const { return line_place(name, text, at.data()); }
    [[nodiscard]] std::string end() const { return line_place(name, text, text.data() + text.size()); }
};

/// The zones of a file, one where it tells of none.
struct File {
    std::vector<Zone> zones;
    bool ended = true;  ///< its last line, by a line break
};

/// Finds the blocks of all zones. Errors: input (rows that are missing, blocks that come twice).
[[nodiscard]] Outcome<File> find_blocks(std::string_view text, std::string_view name);

}  // namespace camber::su2
