// A second, independent encoder: writes binary GMF files of any version and byte order word by word.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

struct BinaryFile {
    int version = 2;
    bool swapped = false;
    std::vector<std::byte> bytes = {};
    std::size_t position_at = 0;

    BinaryFile(int version_, bool swapped_) : version(version_), swapped(swapped_) {
        word(std::int32_t{1});
        word(std::int32_t{version});
    }

    template <class T>
    void word(T value) {
        auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
        if (swapped) std::reverse(raw.begin(), raw.end());
        bytes.insert(bytes.end(), raw.begin(), raw.end());
    }
    void integer(std::int64_t value) {
        if (version == 4)
            word(value);
        else
            word(static_cast<std::int32_t>(value));
    }
    void real(double value) {
        if (version == 1)
            word(static_cast<float>(value));
        else
            word(value);
    }
    void position(std::int64_t value) {
        if (version >= 3)
            word(value);
        else
            word(static_cast<std::int32_t>(value));
    }
    /// Begins a block without a count.
    void keyword(std::int32_t number) {
        word(number);
        position_at = bytes.size();
        position(0);
    }
    void block(std::int32_t number, std::int64_t count) {
        keyword(number);
        integer(count);
    }
    /// Writes the position where the block ends.
    void close() {
        const std::size_t end = bytes.size();
        const std::vector<std::byte> all = bytes;
        bytes.resize(position_at);
        position(static_cast<std::int64_t>(end));
        bytes.insert(bytes.end(), all.begin() + static_cast<std::ptrdiff_t>(bytes.size()), all.end());
    }
    void dimension(std::int32_t d) {
        keyword(3);
        word(d);
        close();
    }
    void end() {
        word(std::int32_t{54});
        position(0);
    }
};
