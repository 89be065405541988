module;
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
module camber.io;
import camber.core;

namespace camber::gmf {

namespace {

/// Reads headers, never beyond the end of the bytes.
class Header {
  public:
    Header(const File& file, std::size_t at) : file_(file), at_(at) {}

    [[nodiscard]] std::size_t at() const { return at_; }

    /// An integer of 4 or 8 bytes, or none when the file ends before.
    [[nodiscard]] std::optional<std::int64_t> integer(std::size_t size) {
        if (file_.bytes.size() - at_ < size) return std::nullopt;
        const std::byte* const from = file_.bytes.data() + at_;
        at_ += size;
        const bool swapped = file_.order == ByteOrder::swapped;
        if (size == 4)
            return swapped ? load<std::int32_t, ByteOrder::swapped>(from) : load<std::int32_t, ByteOrder::native>(from);
        return swapped ? load<std::int64_t, ByteOrder::swapped>(from) : load<std::int64_t, ByteOrder::native>(from);
    }

  private:
    const File& file_;
    std::size_t at_;
};

auto cut_off(const File& file) {
    return fail_at(file, file.bytes.size(), "the file ends before the keyword End", "it seems to be cut off");
}

/// The number and the types of a solution's fields.
Outcome<Done> read_fields(const File& file, Header& header, Block& block) {
    const auto number = header.integer(4);
    if (!number || header.at() > block.end || *number < 1 ||
        static_cast<std::size_t>(*number) > (block.end - header.at()) / 4)
        return fail_at(file, block.start, "SolAtVertices has no list of fields, or one that does not fit the file");
    for (std::int64_t i = 0; i < *number; ++i) block.fields.push_back(static_cast<std::int32_t>(*header.integer(4)));
    return Done{};
}

Outcome<Done> read_block(File& file, Header header, std::int32_t number, std::size_t start, std::size_t end) {
    const KeywordInfo* const info = find_keyword(number);
    if (!info) {
        skip_block(file, std::to_string(number));
        return Done{};
    }
    const std::string name(info->name);
    const std::size_t room = end - header.at();
    if (info->content == Content::value) {
        // Dimension keeps 4 bytes in version 4; the block's length tells for the others.
        const auto value = header.integer(file.version == 4 && room >= 8 ? 8 : 4);
        if (!value || header.at() > end) return fail_at(file, start, name + " has no value", "the file is damaged");
        set_value(file, info->keyword, *value);
        return Done{};
    }
    const auto count = header.integer(file.version == 4 ? 8 : 4);
    if (!count || header.at() > end || *count < 0)
        return fail_at(file, start, name + " has no count, or a negative one", "the file is damaged");
    Block block{.info = info, .start = start, .end = end, .count = static_cast<std::uint64_t>(*count)};
    if (info->content == Content::solution)
        if (auto fields = read_fields(file, header, block); !fields) return fields;
    block.body = header.at();
    if (info->content != Content::foreign_elements || block.count > 0) file.blocks.push_back(std::move(block));
    return Done{};
}

}  // namespace

Outcome<File> index_binary(File file) {
    Header start(file, 4);
    const auto version = start.integer(4);
    if (!version) return cut_off(file);
    if (*version < 1 || *version > 4)
        return fail(ErrorKind::unsupported, "GMF version " + std::to_string(*version) + " is not 1 to 4",
                    place(file, 4));
    file.version = static_cast<int>(*version);
    const std::size_t position_size = file.version >= 3 ? 8 : 4;

    std::size_t at = start.at();
    for (;;) {
        Header header(file, at);
        const auto number = header.integer(4);
        if (!number) return cut_off(file);
        if (*number == static_cast<std::int32_t>(Keyword::end)) return file;
        const auto next = header.integer(position_size);
        if (!next) return cut_off(file);
        if (*next < static_cast<std::int64_t>(header.at()) || static_cast<std::uint64_t>(*next) > file.bytes.size())
            return fail_at(file, at,
                           "the block after keyword " + std::to_string(*number) + " is said to be at byte " +
                               std::to_string(*next) + ", which is not between here and the file's end",
                           "the file is cut off or damaged");
        const auto end = static_cast<std::size_t>(*next);
        auto read = read_block(file, header, static_cast<std::int32_t>(*number), at, end);
        if (!read) return fail(std::move(read.error()));
        at = end;
    }
}

}  // namespace camber::gmf
