module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io:vtu_arrays;
import camber.core;
import :any_mesh;
import :legal_names;
import :solution;

namespace camber::vtu {

/// VTK's name of a number.
template <class T>
inline constexpr std::string_view type_name = [] {
    if constexpr (std::is_same_v<T, double>) return std::string_view("Float64");
    if constexpr (std::is_same_v<T, std::int64_t>) return std::string_view("Int64");
    if constexpr (std::is_same_v<T, std::int32_t>) return std::string_view("Int32");
    if constexpr (std::is_same_v<T, std::uint8_t>) return std::string_view("UInt8");
}();

/// The name of an array and those of its components; none for a scalar.
struct ArrayName {
    std::string name;
    std::vector<std::string> components = {};
};

/// The appended data of a VTU file: arrays behind one another, each a header (blocks, bytes of a block, bytes of a last
/// and shorter one or 0, compressed bytes of each; all UInt64) and its blocks, each compressed by itself.
class AppendedArrays {
  public:
    explicit AppendedArrays(const Execution& execution) : execution_(execution) {}

    /// Appends n numbers, value(i) each, called in parallel; the DataArray element that stands for them.
    template <class T, class Value>
    [[nodiscard]] Outcome<std::string> add(const ArrayName& name, std::size_t n, Value&& value) {
        const auto fill = [&](std::size_t first, std::size_t last, std::byte* to) {
            for (std::size_t i = first; i < last; ++i, to += sizeof(T)) {
                const T number = value(i);
                std::memcpy(to, &number, sizeof number);
            }
        };
        return append(type_name<T>, name, n, sizeof(T), fill);
    }

    /// The file: this XML up to the data, then the data, then the end of the XML.
    [[nodiscard]] Chunks finish(std::string_view xml) &&;

  private:
    [[nodiscard]] Outcome<std::string> append(
        std::string_view type, const ArrayName& name, std::size_t n, std::size_t size,
        const std::function<void(std::size_t first, std::size_t last, std::byte* to)>& fill);

    const Execution& execution_;
    Chunks chunks_;
    std::size_t bytes_ = 0;
};

/// The components that VTK wants of a field, by where they stand in a row of ours; −1: zero.
struct Components {
    std::vector<std::string> names;
    std::vector<int> sources;
};
[[nodiscard]] Components components_of(FieldKind kind, int dimension);

/// Names of fields in VTK's files: none is empty, nor that of an array with another meaning; of XML.
[[nodiscard]] FieldNames field_names();

/// A text for an XML attribute.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace camber::vtu
