module;
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
module camber.distributed;
import camber.core;
import :error_bytes;
import :ranks;

namespace camber {

namespace {

/// A number, or a text after its length.
void put(Bytes& bytes, std::uint64_t number) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof number);
    std::memcpy(bytes.data() + at, &number, sizeof number);
}
void put(Bytes& bytes, const std::string& text) {
    put(bytes, text.size());
    const std::size_t at = bytes.size();
    bytes.resize(at + text.size());
    if (!text.empty()) std::memcpy(bytes.data() + at, text.data(), text.size());
}

/// Takes what `put` gave, in the same turn; what is not there is 0 or empty.
class Taker {
  public:
    explicit Taker(const Bytes& bytes) : bytes_(bytes) {}
    [[nodiscard]] std::uint64_t number() {
        std::uint64_t number = 0;
        if (bytes_.size() - at_ < sizeof number) return 0;
        std::memcpy(&number, bytes_.data() + at_, sizeof number);
        at_ += sizeof number;
        return number;
    }
    [[nodiscard]] std::string text() {
        const std::uint64_t size = number();
        if (bytes_.size() - at_ < size) return {};
        std::string text(size, '\0');
        if (size > 0) std::memcpy(text.data(), bytes_.data() + at_, size);
        at_ += size;
        return text;
    }

  private:
    const Bytes& bytes_;
    std::size_t at_ = 0;
};

}  // namespace

Bytes packed(const Error& error) {
    Bytes bytes;
    put(bytes, static_cast<std::uint64_t>(error.kind));
    for (const std::string* const text : {&error.what, &error.where, &error.remedy}) put(bytes, *text);
    put(bytes, std::uint64_t{error.entity ? 1U : 0U});
    if (error.entity) {
        put(bytes, error.entity->kind);
        put(bytes, error.entity->number);
    }
    return bytes;
}

Error unpacked_error(const Bytes& bytes) {
    Taker take(bytes);
    Error error;
    error.kind = static_cast<ErrorKind>(take.number());
    for (std::string* const text : {&error.what, &error.where, &error.remedy}) *text = take.text();
    if (take.number() == 0) return error;
    std::string kind = take.text();
    error.entity = Entity{std::move(kind), take.number()};
    return error;
}

}  // namespace camber
