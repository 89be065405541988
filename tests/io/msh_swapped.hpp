// Converts a binary MSH file to the other byte order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "generated.hpp"

namespace msh_swapped {

/// Walks through a file that Camber wrote and reverses the bytes of each number.
class Walk {
  public:
    explicit Walk(generated::Bytes bytes) : bytes_(std::move(bytes)) {}

    generated::Bytes done() && {
        const bool four = rest().find("4.1 1 8") < 40;
        section("$MeshFormat");
        line();
        number<std::int32_t>();
        if (four) version_4();
        if (!four) version_2();
        while (rest().find("Data\n") < rest().size()) data();
        return std::move(bytes_);
    }

  private:
    [[nodiscard]] std::string_view rest() const {
        return {reinterpret_cast<const char*>(bytes_.data()) + at_, bytes_.size() - at_};
    }
    /// Moves behind the first line of the next section of this name.
    void section(std::string_view name) {
        const std::string first = std::string(name) + "\n";
        at_ += rest().find(first) + first.size();
    }
    std::string_view line() {
        const std::string_view text = rest().substr(0, rest().find('\n'));
        at_ += text.size() + 1;
        return text;
    }
    template <class T>
    T number() {
        T value;
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        std::reverse(bytes_.begin() + static_cast<std::ptrdiff_t>(at_),
                     bytes_.begin() + static_cast<std::ptrdiff_t>(at_ + sizeof value));
        at_ += sizeof value;
        return value;
    }
    template <class T>
    void numbers(std::uint64_t n) {
        for (; n > 0; --n) static_cast<void>(number<T>());
    }
    void list() { numbers<std::int32_t>(number<std::uint64_t>()); }

    void version_4() {
        section("$Entities");
        std::uint64_t counts[4];
        for (auto& count : counts) count = number<std::uint64_t>();
        for (int d = 0; d < 4; ++d)
            for (std::uint64_t n = counts[d]; n > 0; --n) {
                number<std::int32_t>();
                numbers<double>(d == 0 ? 3 : 6);
                list();
                if (d > 0) list();
            }
        section("$Nodes");
        std::uint64_t blocks = number<std::uint64_t>();
        numbers<std::uint64_t>(3);
        for (; blocks > 0; --blocks) {
            const auto dimension = number<std::int32_t>();
            number<std::int32_t>();
            const bool parametric = number<std::int32_t>() != 0;
            const auto n = number<std::uint64_t>();
            numbers<std::uint64_t>(n);
            numbers<double>(n * static_cast<std::uint64_t>(3 + (parametric ? dimension : 0)));
        }
        section("$Elements");
        blocks = number<std::uint64_t>();
        numbers<std::uint64_t>(3);
        for (; blocks > 0; --blocks) {
            numbers<std::int32_t>(2);
            const auto type = number<std::int32_t>();
            const auto n = number<std::uint64_t>();
            numbers<std::uint64_t>(n * (1 + nodes_of(type)));
        }
    }
    void version_2() {
        section("$Nodes");
        for (auto n = std::stoul(std::string(line())); n > 0; --n) {
            number<std::int32_t>();
            numbers<double>(3);
        }
        section("$Elements");
        for (auto n = std::stoul(std::string(line())); n > 0;) {
            const auto type = number<std::int32_t>();
            const auto rows = static_cast<std::uint64_t>(number<std::int32_t>());
            const auto tags = static_cast<std::uint64_t>(number<std::int32_t>());
            numbers<std::int32_t>(rows * (1 + tags + nodes_of(type)));
            n -= rows;
        }
    }
    void data() {
        section("Data");
        for (int i = 0; i < 6; ++i) line();
        const auto components = std::stoul(std::string(line()));
        for (auto n = std::stoul(std::string(line())); n > 0; --n) {
            number<std::int32_t>();
            numbers<double>(components);
        }
        section("Data");
    }
    static std::uint64_t nodes_of(std::int32_t type) {
        switch (type) {
            case 15: return 1;
            case 1: return 2;
            case 8: return 3;
            case 2: return 3;
            case 9: return 6;
            case 4: return 4;
            default: return 10;
        }
    }

    generated::Bytes bytes_;
    std::size_t at_ = 0;
};

inline generated::Bytes swapped(const generated::Bytes& bytes) { return Walk(bytes).done(); }

}  // namespace msh_swapped
