module;
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.config:codec;
import camber.core;
import camber.recipes;
import :renames;
import camber.validity;

namespace camber::config {

using Json = nlohmann::ordered_json;

/// A position in a config: the file's name and a JSON pointer.
struct Place {
    std::string file, pointer;

    [[nodiscard]] Place at(std::string_view key) const { return {file, pointer + "/" + shortened(key)}; }
    [[nodiscard]] Place at(std::size_t index) const { return at(std::to_string(index)); }
    [[nodiscard]] std::string text() const {
        if (pointer.empty()) return file.empty() ? "/" : file;
        return file.empty() ? pointer : file + ": " + pointer;
    }
};

[[nodiscard]] inline auto bad(const Place& place, std::string what, std::string remedy = {}) {
    return fail(ErrorKind::usage, std::move(what), place.text(), {}, std::move(remedy));
}

/// The type for messages: "a string", "a number" …
[[nodiscard]] std::string kind_of(const Json& json);

/// Errors: usage; syntax with line and column, duplicate keys with their path.
[[nodiscard]] Outcome<Json> parse_json(std::string_view text, std::string_view name);

/// Applies `path=value` to a config. Errors: usage, an invalid path.
[[nodiscard]] Outcome<Done> override_value(Json& json, std::string_view assignment);

/// Empty if no candidate is near.
[[nodiscard]] std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// `did you mean "…"?`, or all candidates.
[[nodiscard]] std::string suggestion(std::string_view word, const std::vector<std::string>& candidates);

/// The error states the successor of an old name, otherwise `what`.
[[nodiscard]] Error unknown_word(NameKind kind, const std::string& word, const std::vector<std::string>& candidates,
                                 const Place& place, std::string what);

/// Reads values from JSON, writes and describes them. Addresses of values are untyped, so that all types share these
/// functions. `codec_of<T>` is the codec of T.
class Codec {
  public:
    Codec() = default;
    Codec(const Codec&) = default;
    Codec(Codec&&) = default;
    Codec& operator=(const Codec&) = default;
    Codec& operator=(Codec&&) = default;
    virtual ~Codec() = default;

    [[nodiscard]] virtual Outcome<Done> read(const Json&, const Place&, const Limits&, void* into) const = 0;
    [[nodiscard]] virtual Json write(const void* value) const = 0;
    [[nodiscard]] virtual Json schema(const Limits&) const = 0;
    [[nodiscard]] virtual std::string type(const Limits&) const = 0;
    [[nodiscard]] virtual bool may_be_bare() const { return false; }
};

/// Specialised in describe_*.cpp for each struct and variant.
template <class T>
struct Described;  // static const Description / Choice / Wrapper& get()

template <class T>
const Codec& codec_of();
template <>
const Codec& codec_of<double>();
template <>
const Codec& codec_of<std::string>();
template <>
const Codec& codec_of<FilePath>();
/// The bound is a number, or null if it is only recommended.
template <>
const Codec& codec_of<JacobianBound>();

template <class T>
[[nodiscard]] Json written(const T& value) {
    return codec_of<T>().write(&value);
}

/// Checks a whole number. `fits`: the type can store it.
[[nodiscard]] Outcome<Done> check_integer(const Json& json, const Place& place, const Limits& limits, bool fits);
[[nodiscard]] Json integer_schema(const Limits& limits, bool is_unsigned);
[[nodiscard]] std::string integer_type(const Limits& limits);

template <std::integral T>
class IntegerCodec : public Codec {
    Outcome<Done> read(const Json& json, const Place& place, const Limits& limits, void* into) const override {
        const bool fits = json.is_number_unsigned()
                              ? std::in_range<T>(json.get<std::uint64_t>())
                              : json.is_number_integer() && std::in_range<T>(json.get<std::int64_t>());
        auto checked = check_integer(json, place, limits, fits);
        if (checked) *static_cast<T*>(into) = json.get<T>();
        return checked;
    }
    Json write(const void* value) const override { return *static_cast<const T*>(value); }
    Json schema(const Limits& limits) const override { return integer_schema(limits, std::is_unsigned_v<T>); }
    std::string type(const Limits& limits) const override { return integer_type(limits); }
};

class WordCodec : public Codec {
  public:
    template <HasWords T>
    explicit WordCodec(T) {
        static_assert(sizeof(T) == 1);
        for (const auto& w : words(T{})) {
            words_.emplace_back(w.word);
            values_.push_back(static_cast<unsigned char>(w.value));
        }
    }
    Outcome<Done> read(const Json& json, const Place& place, const Limits& limits, void* into) const override;
    Json write(const void* value) const override;
    Json schema(const Limits&) const override;
    std::string type(const Limits&) const override;

  private:
    std::vector<std::string> words_;
    std::vector<unsigned char> values_;
};

class ListCodec : public Codec {
  public:
    explicit ListCodec(const Codec& items) : items_(&items) {}
    Outcome<Done> read(const Json& json, const Place& place, const Limits& limits, void* into) const override;
    Json write(const void* list) const override;
    Json schema(const Limits& limits) const override;
    std::string type(const Limits& limits) const override;

  private:
    /// Combines the limits of option and type.
    [[nodiscard]] virtual Limits counted(const Limits& limits) const { return limits; }
    [[nodiscard]] virtual std::size_t size(const void* list) const = 0;
    /// Fills the list with `size` default values.
    virtual void renew(void* list, std::size_t size) const = 0;
    [[nodiscard]] virtual void* item(void* list, std::size_t i) const = 0;

    const Codec* items_;
};
[[nodiscard]] std::string list_type(const std::string& item, const Limits& limits);

template <class T>
class VectorCodec : public ListCodec {
  public:
    VectorCodec() : ListCodec(codec_of<T>()) {}

  private:
    using List = std::vector<T>;
    std::size_t size(const void* list) const override { return static_cast<const List*>(list)->size(); }
    void renew(void* list, std::size_t size) const override { *static_cast<List*>(list) = List(size); }
    void* item(void* list, std::size_t i) const override { return &(*static_cast<List*>(list))[i]; }
};
template <class T, std::size_t N>
class ArrayCodec : public ListCodec {
  public:
    ArrayCodec() : ListCodec(codec_of<T>()) {}

  private:
    Limits counted(const Limits& limits) const override {
        Limits exactly = limits;
        exactly.min_count = exactly.max_count = N;
        return exactly;
    }
    std::size_t size(const void*) const override { return N; }
    void renew(void*, std::size_t) const override {}
    void* item(void* list, std::size_t i) const override { return &(*static_cast<std::array<T, N>*>(list))[i]; }
};

/// Codec of a type that has no name in configs.
template <class T>
struct Unnamed;
template <std::integral T>
struct Unnamed<T> {
    IntegerCodec<T> codec;
};
template <HasWords T>
struct Unnamed<T> {
    WordCodec codec{T{}};
};
template <class T>
struct Unnamed<std::vector<T>> {
    VectorCodec<T> codec;
};
template <class T, std::size_t N>
struct Unnamed<std::array<T, N>> {
    ArrayCodec<T, N> codec;
};
template <int D>
struct Unnamed<Vec<D>> {
    ArrayCodec<double, D> codec;  ///< a Vec is read as an array
};

template <class T>
const Codec& codec_of() {
    if constexpr (requires { Described<T>::get(); }) {
        return Described<T>::get();
    } else {
        static const Unnamed<T> unnamed;
        return unnamed.codec;
    }
}

}  // namespace camber::config
