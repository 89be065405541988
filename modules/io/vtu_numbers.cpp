// Reads numbers of VTU files: encodings, compressed blocks, types.
module;
#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber::vtu {

namespace {

auto damaged(const File& file, const DataArray& array, const std::string& what) {
    return fail(ErrorKind::input, "the array " + array.name + ": " + what, place(file, array.at), {},
                "the file is cut off or damaged");
}

// ---------------------------------------------------------------- bytes

void swap_bytes(std::span<std::byte> bytes, std::size_t size) {
    for (std::size_t i = 0; i + size <= bytes.size(); i += size)
        std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                     bytes.begin() + static_cast<std::ptrdiff_t>(i + size));
}

std::optional<std::uint64_t> next_word(const File& file, Bytes& bytes) {
    auto taken = bytes.take(file.word);
    if (!taken) return std::nullopt;
    if (file.swapped) swap_bytes(*taken, file.word);
    std::uint64_t wide = 0;
    std::uint32_t narrow = 0;
    if (file.word == sizeof wide)
        std::memcpy(&wide, taken->data(), sizeof wide);
    else
        std::memcpy(&narrow, taken->data(), sizeof narrow);
    return file.word == sizeof wide ? wide : narrow;
}

// ---------------------------------------------------------------- compressed data

constexpr std::string_view name_of(Compressor compressor) {
    switch (compressor) {
        case Compressor::lz4: return "LZ4";
        case Compressor::lzma: return "LZMA";
        default: return "zlib";
    }
}

struct Block {
    std::size_t begin = 0, packed = 0;  ///< position and size in the compressed bytes
    std::size_t to = 0, size = 0;       ///< position and size in the uncompressed bytes
};

constexpr std::uint64_t max_expansion(Compressor compressor) {
    switch (compressor) {
        case Compressor::lz4: return 255;
        case Compressor::lzma: return 16384;
        default: return 1032;
    }
}

std::optional<std::vector<Block>> read_blocks(const File& file, Bytes& bytes) {
    const auto count = next_word(file, bytes);
    if (!count) return std::nullopt;
    std::vector<Block> blocks;
    if (*count == 0) return blocks;
    const auto full = next_word(file, bytes), last = next_word(file, bytes);
    if (!full || !last || *count > bytes.most() / file.word) return std::nullopt;
    blocks.resize(*count);
    std::size_t packed = 0, to = 0;
    for (Block& block : blocks) {
        const auto size = next_word(file, bytes);
        const std::uint64_t unpacked = &block == &blocks.back() && *last != 0 ? *last : *full;
        if (!size || *size > bytes.most() || unpacked / max_expansion(file.compressor) > *size) return std::nullopt;
        block = {packed, *size, to, unpacked};
        packed += *size;
        to += unpacked;
        if (packed > bytes.most()) return std::nullopt;
    }
    return blocks;
}

Outcome<Buffer<std::byte>> unpacked(const File& file, const DataArray& array, Bytes& bytes, std::uint64_t most,
                                    const Execution& execution) {
    const auto blocks = read_blocks(file, bytes);
    if (!blocks) return damaged(file, array, "the header of its compressed blocks is wrong");
    if (blocks->empty()) return Buffer<std::byte>{};
    const Block& last = blocks->back();
    if (last.to + last.size > most)
        return damaged(file, array,
                       "its compressed blocks announce " + std::to_string(last.to + last.size) +
                           " bytes, but the counts of the file make " + std::to_string(most));
    const auto packed = bytes.take(last.begin + last.packed);
    if (!packed) return damaged(file, array, "its compressed data end too soon");
    Buffer<std::byte> out(last.to + last.size);
    FirstErrorRow first;
    auto done = each(
        execution, blocks->size(),
        [&](std::size_t b) {
            const Block& block = (*blocks)[b];
            const std::span<const std::byte> from(*packed);
            const std::span<std::byte> to(out);
            if (!uncompress_block(file.compressor, from.subspan(block.begin, block.packed),
                                  to.subspan(block.to, block.size)))
                first.note(b);
        },
        1);
    if (!done) return fail(std::move(done.error()));
    if (first.any()) return damaged(file, array, std::string(name_of(file.compressor)) + " cannot uncompress it");
    return out;
}

Outcome<Buffer<std::byte>> plain(const File& file, const DataArray& array, Bytes& bytes) {
    const auto size = next_word(file, bytes);
    auto taken = size ? bytes.take(*size) : std::nullopt;
    if (!taken) return damaged(file, array, "its data end too soon");
    return std::move(*taken);
}

Outcome<Buffer<std::byte>> binary(const File& file, const DataArray& array, Bytes bytes, std::uint64_t most,
                                  const Execution& execution) {
    return file.compressor != Compressor::none ? unpacked(file, array, bytes, most, execution)
                                               : plain(file, array, bytes);
}

std::optional<Bytes> bytes_of(const File& file, const DataArray& array) {
    if (array.format == "binary") return Bytes(array.text, Encoding::base64);
    if (array.format != "appended" || array.offset > file.appended.size()) return std::nullopt;
    return Bytes(file.appended.substr(array.offset), file.encoding);
}

/// Sizes of an array in bytes: as stored, with its header; and uncompressed (0 for data that is not compressed).
struct Sizes {
    std::uint64_t stored = 0, unpacked = 0;
};
std::optional<Sizes> sizes_of(const File& file, Bytes bytes) {
    if (file.compressor == Compressor::none) {
        const auto size = next_word(file, bytes);
        return size && *size <= bytes.most() ? std::optional(Sizes{file.word + *size}) : std::nullopt;
    }
    const auto blocks = read_blocks(file, bytes);
    if (!blocks) return std::nullopt;
    if (blocks->empty()) return Sizes{file.word};
    const Block& last = blocks->back();
    return Sizes{file.word * (3 + blocks->size()) + last.begin + last.packed, last.to + last.size};
}

// ---------------------------------------------------------------- numbers

template <class T>
Outcome<Numbers> numbers_of(const File& file, const DataArray& array, Outcome<Buffer<std::byte>> bytes) {
    if (!bytes) return fail(std::move(bytes.error()));
    if (bytes->size() % sizeof(T) != 0)
        return damaged(
            file, array,
            "its " + std::to_string(bytes->size()) + " bytes are not a multiple of the size of " + array.type);
    if (file.swapped) swap_bytes(*bytes, sizeof(T));
    Buffer<T> numbers(bytes->size() / sizeof(T));
    if (!numbers.empty()) std::memcpy(numbers.data(), bytes->data(), bytes->size());
    return numbers;
}

template <class T>
bool read_word(Words& words, T& value) {
    if constexpr (std::is_floating_point_v<T>) {
        double wide = 0;
        const bool good = read_number(words, wide);
        value = static_cast<T>(wide);
        return good;
    } else {
        const auto [stop, error] = std::from_chars(words.at, words.end, value);
        words.at = stop;
        return error == std::errc{} && words.at_word_end();
    }
}

template <class T>
Outcome<Numbers> text_of(const File& file, const DataArray& array) {
    Words words{array.text.data(), array.text.data() + array.text.size()};
    Buffer<T> numbers;
    while (words.find()) {
        T value{};
        if (!read_word(words, value))
            return damaged(file, array,
                           "number " + std::to_string(numbers.size() + 1) + " is malformed, or too large for its kind");
        numbers.push_back(value);
    }
    return numbers;
}

std::uint64_t saturated_product(std::uint64_t a, std::uint64_t b) {
    constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
    return b != 0 && a > most / b ? most : a * b;
}

template <class T>
Outcome<Numbers> read_as(const File& file, const DataArray& array, std::uint64_t rows, const Execution& execution) {
    if (array.format == "ascii") return text_of<T>(file, array);
    const std::uint64_t most = saturated_product(saturated_product(rows, array.components), sizeof(T));
    if (const auto bytes = bytes_of(file, array))
        return numbers_of<T>(file, array, binary(file, array, *bytes, most, execution));
    if (array.format != "appended")
        return fail(ErrorKind::unsupported, "the array " + array.name + " is neither ascii, binary nor appended",
                    place(file, array.at));
    return damaged(file, array, "its offset is not within the AppendedData");
}

struct NumberType {
    std::string_view name;
    std::size_t bytes;
    Outcome<Numbers> (*read)(const File&, const DataArray&, std::uint64_t, const Execution&);
};
template <class T>
constexpr NumberType number_type(std::string_view name) {
    return {name, sizeof(T), read_as<T>};
}
constexpr std::array number_types{number_type<double>("Float64"),     number_type<float>("Float32"),
                                  number_type<std::int8_t>("Int8"),   number_type<std::uint8_t>("UInt8"),
                                  number_type<std::int16_t>("Int16"), number_type<std::uint16_t>("UInt16"),
                                  number_type<std::int32_t>("Int32"), number_type<std::uint32_t>("UInt32"),
                                  number_type<std::int64_t>("Int64"), number_type<std::uint64_t>("UInt64")};

const NumberType* type_of(const DataArray& array) {
    const auto* const found = std::ranges::find(number_types, array.type, &NumberType::name);
    return found == number_types.end() ? nullptr : &*found;
}

struct Budget {
    std::uint64_t left;
    UnpackedBudget unpacked;
};

Outcome<Done> check_size(const File& file, const DataArray& array, Budget& budget) {
    const NumberType* const type = type_of(array);
    const auto bytes = type != nullptr ? bytes_of(file, array) : std::nullopt;
    if (!bytes || bytes->most() == 0) return Done{};
    const auto size = sizes_of(file, *bytes);
    if (!size) return damaged(file, array, "its header is wrong, or its data end too soon");
    if (size->stored > budget.left) return damaged(file, array, "it and those before it have more bytes than the file");
    budget.left -= size->stored;
    // The budget counts numbers instead of bytes, because small types are converted to 8 bytes in memory.
    if (budget.unpacked.take(size->unpacked / type->bytes)) return Done{};
    return fail(ErrorKind::input,
                "the array " + array.name + ": uncompressed, it and those before it would have more than " +
                    std::to_string(UnpackedBudget::most(file.bytes.size()) >> 20U) +
                    " MiB, which is implausible for a file of " + std::to_string(file.bytes.size()) + " bytes",
                place(file, array.at), {}, "the file is damaged; if it is whole, write it uncompressed");
}

void append(Numbers& all, const Numbers& more) {
    std::visit(
        [&]<class T>(Buffer<T>& numbers) {
            const auto& added = std::get<Buffer<T>>(more);
            numbers.insert(numbers.end(), added.begin(), added.end());
        },
        all);
}

}  // namespace

Outcome<Done> check_sizes(const File& file) {
    Budget budget{file.bytes.size(), UnpackedBudget(file.bytes.size())};
    for (const auto* const section : {&file.point_data, &file.cell_data, &file.point_arrays, &file.cell_arrays})
        for (const DataArray& array : *section) {
            if (auto sound = check_size(file, array, budget); !sound) return sound;
            for (const DataArray& other : array.other_pieces)
                if (auto sound = check_size(file, other, budget); !sound) return sound;
        }
    return Done{};
}

bool is_number(const DataArray& array) { return array.numbers || type_of(array) != nullptr; }

Outcome<Numbers> read_array(const File& file, const DataArray& array, std::uint64_t rows, const Execution& execution) {
    if (array.numbers) return *array.numbers;
    const NumberType* const type = type_of(array);
    if (type == nullptr)
        return fail(ErrorKind::unsupported, "the array " + array.name + " is not numeric", place(file, array.at));
    auto numbers = type->read(file, array, rows, execution);
    for (const DataArray& other : array.other_pieces) {
        if (!numbers) break;
        const auto more = type->read(file, other, rows, execution);
        if (!more) return more;
        append(*numbers, *more);
    }
    return numbers;
}

}  // namespace camber::vtu
