// Reads number arrays of legacy VTK files; converts numbers to references and field values.
module;
#include <algorithm>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber::vtk {

namespace {

template <class T>
Outcome<vtu::Numbers> text_numbers(Source& source, std::uint64_t n) {
    if (n > (source.text.size() - source.at + 1) / 2)
        return source.wrong("announces " + std::to_string(n) + " numbers, but fewer follow");
    Buffer<T> numbers;
    numbers.reserve(n);
    Words words{source.text.data() + source.at, source.text.data() + source.text.size()};
    for (std::uint64_t i = 0; i < n; ++i) {
        bool sound = false;
        if constexpr (std::is_floating_point_v<T>) {
            double value = 0;
            sound = read_number(words, value);
            numbers.push_back(static_cast<T>(value));
        } else {
            T value{};
            if (words.find()) {
                const auto [stop, error] = std::from_chars(words.at, words.end, value);
                words.at = stop;
                sound = error == std::errc{} && words.at_word_end();
            }
            numbers.push_back(value);
        }
        if (!sound) {
            source.at = static_cast<std::size_t>(words.at - source.text.data());
            return source.wrong("number " + std::to_string(i + 1) + " of " + std::to_string(n) +
                                " is missing, malformed or too large for its kind");
        }
    }
    source.at = static_cast<std::size_t>(words.at - source.text.data());
    return numbers;
}

/// Reads n numbers from the next line on; their most significant byte is first.
template <class T>
Outcome<vtu::Numbers> binary_numbers(Source& source, std::uint64_t n) {
    source.line();
    if (n > (source.text.size() - source.at) / sizeof(T))
        return source.wrong("announces " + std::to_string(n) + " numbers, but fewer follow");
    Buffer<T> numbers(n);
    if (n > 0) std::memcpy(numbers.data(), source.text.data() + source.at, n * sizeof(T));
    source.at += n * sizeof(T);
    if constexpr (sizeof(T) > 1 && std::endian::native == std::endian::little)
        for (T& number : numbers) {
            auto* const begin = reinterpret_cast<std::byte*>(&number);
            std::reverse(begin, begin + sizeof(T));
        }
    return numbers;
}

template <class T>
Outcome<vtu::Numbers> numbers_of(Source& source, std::uint64_t n) {
    return source.binary ? binary_numbers<T>(source, n) : text_numbers<T>(source, n);
}

Outcome<vtu::Numbers> bits(Source& source, std::uint64_t n) {
    if (!source.binary) return text_numbers<std::uint8_t>(source, n);
    return binary_numbers<std::uint8_t>(source, (n + 7) / 8).map([&](const vtu::Numbers& packed) -> vtu::Numbers {
        const auto& bytes = std::get<Buffer<std::uint8_t>>(packed);
        Buffer<std::uint8_t> numbers(n);
        for (std::uint64_t i = 0; i < n; ++i)
            numbers[i] = static_cast<std::uint8_t>(bytes[i / 8] >> (7U - i % 8U) & 1U);
        return numbers;
    });
}

}  // namespace

Outcome<vtu::Numbers> Source::numbers(const std::string& type, std::uint64_t rows, std::uint64_t components) {
    if (components != 0 && rows > std::numeric_limits<std::uint64_t>::max() / components)
        return wrong("has more numbers than can be counted");
    const std::uint64_t n = rows * components;
    if (type == "vtktypeint32") return numbers_of<std::int32_t>(*this, n);
    if (type == "vtktypeuint32") return numbers_of<std::uint32_t>(*this, n);
    if (type == "vtktypeint16") return numbers_of<std::int16_t>(*this, n);
    if (type == "vtktypeuint16") return numbers_of<std::uint16_t>(*this, n);
    if (type == "vtktypeint8") return numbers_of<std::int8_t>(*this, n);
    if (type == "vtktypeuint8") return numbers_of<std::uint8_t>(*this, n);
    if (type == "vtktypefloat32") return numbers_of<float>(*this, n);
    if (type == "vtktypefloat64") return numbers_of<double>(*this, n);
    if (type == "double") return numbers_of<double>(*this, n);
    if (type == "float") return numbers_of<float>(*this, n);
    if (type == "int" || type == "vtkidtype") return numbers_of<std::int32_t>(*this, n);
    if (type == "unsigned_int") return numbers_of<std::uint32_t>(*this, n);
    if (type == "vtktypeint64" || type == "long" || type == "vtktypeint64_t") return numbers_of<std::int64_t>(*this, n);
    if (type == "vtktypeuint64" || type == "unsigned_long") return numbers_of<std::uint64_t>(*this, n);
    if (type == "short") return numbers_of<std::int16_t>(*this, n);
    if (type == "unsigned_short") return numbers_of<std::uint16_t>(*this, n);
    if (type == "unsigned_char") return numbers_of<std::uint8_t>(*this, n);
    if (type == "char" || type == "signed_char") return numbers_of<std::int8_t>(*this, n);
    if (type == "bit") return bits(*this, n);
    return refused("has an array of the type " + in_quotes(type) + ", which is not numeric", "write it as .vtu");
}

}  // namespace camber::vtk

namespace camber::vtu {

namespace {

constexpr std::size_t row_grain = 4096;

template <class To, class From>
Outcome<Column<To>> placed(const Buffer<From>& from, const Column<std::uint32_t>* order, const std::vector<int>& places,
                           const Execution& execution) {
    const std::size_t width = places.size(), rows = order ? order->size() : from.size() / width;
    Buffer<To> out(rows * width);
    return each(
               execution, rows,
               [&](std::size_t i) {
                   const std::size_t row = order ? (*order)[i] : i;
                   for (std::size_t k = 0; k < width; ++k)
                       out[i * width + static_cast<std::size_t>(places[k])] = static_cast<To>(from[row * width + k]);
               },
               row_grain)
        .map([&](Done) { return Column<To>(std::move(out)); });
}

template <class From>
Outcome<FieldValues> values_of(const Buffer<From>& from, const Column<std::uint32_t>* order,
                               const std::vector<int>& places, const Execution& execution) {
    const auto as_values = [](auto column) { return FieldValues(std::move(column)); };
    if constexpr (std::is_integral_v<From>)
        if (std::all_of(from.begin(), from.end(), [](From x) { return std::in_range<std::int32_t>(x); }))
            return placed<std::int32_t>(from, order, places, execution).map(as_values);
    return placed<double>(from, order, places, execution).map(as_values);
}

}  // namespace

Outcome<std::optional<Buffer<Reference>>> as_references(const Numbers& numbers, const Execution& execution) {
    return std::visit(
        [&](const auto& values) -> Outcome<std::optional<Buffer<Reference>>> {
            FirstErrorRow first;
            auto result = map_each(
                execution, values.size(),
                [&](std::size_t i) {
                    const auto reference = whole_number<Reference>(values[i]);
                    if (!reference) first.note(i);
                    return reference.value_or(0);
                },
                row_grain);
            if (!result) return fail(std::move(result.error()));
            if (first.any()) return std::nullopt;
            return std::move(*result);
        },
        numbers);
}

Outcome<FieldValues> field_values(const Numbers& numbers, const Column<std::uint32_t>* order,
                                  const std::vector<int>& places, const Execution& execution) {
    return std::visit([&](const auto& from) { return values_of(from, order, places, execution); }, numbers);
}

}  // namespace camber::vtu
