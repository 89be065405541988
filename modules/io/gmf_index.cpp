// Finds the blocks of GMF files: ASCII and binary.
module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::gmf {

namespace {

constexpr bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// True for nan and infinity, which begin with a letter like keywords.
bool spells_number(std::string_view word) {
    std::array<char, 8> lower{};
    const std::size_t n = std::min(word.size(), lower.size());
    std::transform(word.begin(), word.begin() + n, lower.begin(),
                   [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
    const std::string_view start(lower.data(), n);
    return start == "nan" || start == "inf" || start == "infinity" || start.starts_with("nan(");
}

void pass_quoted(Words& words) {
    if (*words.at != '"') return;
    const std::string_view rest(words.at, static_cast<std::size_t>(words.end - words.at));
    const std::size_t end = rest.find_first_of("\"\n", 1);
    if (end != std::string_view::npos && rest[end] == '"') words.at += end;
}

bool find_keyword_word(Words& words) {
    for (; words.find(); words.pass()) {
        pass_quoted(words);
        if (!is_letter(*words.at)) continue;
        Words ahead = words;
        if (!spells_number(ahead.next())) return true;
    }
    return false;
}

constexpr std::size_t piece_bytes = std::size_t{1} << 18;

/// Divides the rows of an ASCII block into parts. Parts end at line ends, so no comment extends over two parts.
Outcome<Done> split(const File& file, Block& block, const Execution& execution) {
    const auto text = file.bytes.first(block.end);
    for (std::size_t at = block.body; at < block.end;) {
        block.pieces.push_back({.begin = at});
        const std::size_t about = std::min(block.end, at + piece_bytes);
        const auto line_end = std::find(text.begin() + about, text.end(), std::byte{'\n'});
        at = line_end == text.end() ? block.end : static_cast<std::size_t>(line_end - text.begin()) + 1;
    }
    auto counted = each(
        execution, block.pieces.size(),
        [&](std::size_t i) {
            const std::size_t end = i + 1 < block.pieces.size() ? block.pieces[i + 1].begin : block.end;
            std::size_t count = 0;
            for (Words words = words_between(file, block.pieces[i].begin, end); words.find(); words.pass()) ++count;
            block.pieces[i].first_word = count;
        },
        1);
    if (!counted) return counted;
    for (Piece& piece : block.pieces) {
        const std::size_t count = piece.first_word;
        piece.first_word = block.words;
        block.words += count;
    }
    return Done{};
}

Outcome<Done> read_text_fields(const File& file, Words& words, Block& block) {
    std::int64_t number = 0;
    bool sound = read_number(words, number) && number >= 1 && number <= words.end - words.at;
    for (std::int64_t i = 0; sound && i < number; ++i) {
        std::int64_t type = 0;
        sound = read_number(words, type);
        block.fields.push_back(static_cast<std::int32_t>(std::clamp<std::int64_t>(type, 0, 99)));
    }
    if (!sound) return fail_at(file, block.start, "SolAtVertices has no list of fields");
    return Done{};
}

Outcome<Done> read_text_block(File& file, std::string_view name, std::size_t start, std::size_t begin, std::size_t end,
                              const Execution& execution) {
    const KeywordInfo* const info = find_keyword(name);
    if (!info) {
        skip_block(file, name);
        return Done{};
    }
    Words words = words_between(file, begin, end);
    std::int64_t number = 0;
    if (!read_number(words, number) || (info->content != Content::value && number < 0))
        return fail_at(file, start, std::string(name) + " is not followed by a valid number");
    if (info->content == Content::value) {
        set_value(file, info->keyword, number);
        return Done{};
    }
    Block block{.info = info, .start = start, .end = end, .count = static_cast<std::uint64_t>(number)};
    if (info->content == Content::foreign_elements) {
        if (number > 0) file.blocks.push_back(std::move(block));
        return Done{};
    }
    if (info->content == Content::solution)
        if (auto fields = read_text_fields(file, words, block); !fields) return fields;
    block.body = static_cast<std::size_t>(words.at - reinterpret_cast<const char*>(file.bytes.data()));
    const auto share = [bytes = static_cast<double>(file.bytes.size())](std::size_t at) {
        return static_cast<double>(at) / bytes;
    };
    if (auto counted = split(file, block, part_of(execution, share(block.body), share(end))); !counted) return counted;
    file.blocks.push_back(std::move(block));
    return Done{};
}

struct Begin {
    Words words;
    bool has_version = true;
};
std::optional<Begin> begin_of(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    Words words{text.data(), text.data() + text.size()};
    if (text.starts_with("\xEF\xBB\xBF")) words.at += 3;
    const Words before = words;
    const std::string_view first = words.next();
    if (first == "MeshVersionFormatted") return Begin{words};
    if (first == "Dimension") return Begin{before, false};
    return std::nullopt;
}

/// Reads the version of a text file. A number from 0 to 4 is accepted (Bamg writes 0), and has no effect.
Outcome<Done> read_version(File& file, Begin& beginning) {
    const auto at = [&] {
        return static_cast<std::size_t>(beginning.words.at - reinterpret_cast<const char*>(file.bytes.data()));
    };
    std::int64_t version = 0;
    if (beginning.has_version && (!read_number(beginning.words, version) || version < 0 || version > 4))
        return fail(ErrorKind::unsupported, "the GMF version is not 1 to 4", place(file, at()));
    file.version = std::max(1, static_cast<int>(version));
    if (!beginning.has_version)
        file.notices.push_back({"the file does not begin with MeshVersionFormatted, but was read as GMF"});
    return Done{};
}

/// Accepts a file without the keyword End, unless the last line has no line end.
Outcome<File> without_end(File file) {
    if (file.bytes.empty() || !is_blank(static_cast<char>(file.bytes.back())))
        return fail_at(file, file.bytes.size(), "the file ends before the keyword End", "it seems to be cut off");
    file.notices.push_back({"the file has no keyword End, so it may be incomplete"});
    return file;
}

}  // namespace

Outcome<File> index_ascii(File file, const Execution& execution) {
    const char* const text = reinterpret_cast<const char*>(file.bytes.data());
    const auto offset = [&](const char* at) { return static_cast<std::size_t>(at - text); };
    auto beginning = begin_of(file.bytes);
    if (!beginning)
        return fail_at(file, 0,
                       "this is not a GMF file: it begins neither with MeshVersionFormatted nor with a binary header",
                       "give a .mesh or .meshb file");
    if (auto read = read_version(file, *beginning); !read) return fail(std::move(read.error()));
    Words& words = beginning->words;

    for (bool found = find_keyword_word(words); found;) {
        const std::size_t start = offset(words.at);
        const std::string_view name = words.next();
        if (name == "End") return file;
        const std::size_t begin = offset(words.at);
        found = find_keyword_word(words);
        auto read = read_text_block(file, name, start, begin, offset(words.at), execution);
        if (!read) return fail(std::move(read.error()));
    }
    return without_end(std::move(file));
}

// ---------------------------------------------------------------- binary files

namespace {

class Header {
  public:
    Header(const File& file, std::size_t at) : file_(file), at_(at) {}

    [[nodiscard]] std::size_t at() const { return at_; }

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

Outcome<Done> read_binary_fields(const File& file, Header& header, Block& block) {
    const auto number = header.integer(4);
    if (!number || header.at() > block.end || *number < 1 ||
        static_cast<std::size_t>(*number) > (block.end - header.at()) / 4)
        return fail_at(file, block.start, "SolAtVertices has no list of fields, or one that does not fit the file");
    for (std::int64_t i = 0; i < *number; ++i) block.fields.push_back(static_cast<std::int32_t>(*header.integer(4)));
    return Done{};
}

Outcome<Done> read_binary_block(File& file, Header header, std::int32_t number, std::size_t start, std::size_t end) {
    const KeywordInfo* const info = find_keyword(number);
    if (!info) {
        skip_block(file, std::to_string(number));
        return Done{};
    }
    const std::string name(info->name);
    const std::size_t room = end - header.at();
    if (info->content == Content::value) {
        // In version 4 a block of one value has 8 bytes, but some writers use 4, as for Dimension. The block's length
        // shows which.
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
        if (auto fields = read_binary_fields(file, header, block); !fields) return fields;
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
                           "the block after keyword " + std::to_string(*number) + " has the position " +
                               std::to_string(*next) + ", which is not between here and the end of the file",
                           "the file is cut off or damaged");
        const auto end = static_cast<std::size_t>(*next);
        auto read = read_binary_block(file, header, static_cast<std::int32_t>(*number), at, end);
        if (!read) return fail(std::move(read.error()));
        at = end;
    }
}

}  // namespace camber::gmf

namespace camber {

bool is_gmf_ascii(std::span<const std::byte> bytes) { return gmf::begin_of(bytes).has_value(); }

}  // namespace camber
