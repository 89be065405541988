module;
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
export module camber.io:mesh_fields;
import camber.core;
import :solution;

export namespace camber {

/// What a field has a row for.
enum class Centring : std::uint8_t {
    node,  ///< each vertex, then (degree 2) the node of each edge in the order of the edge set
    cell,  ///< each element, then each facet, then each feature edge
};

/// Rows one after the other; whole numbers are kept as such.
using FieldValues = std::variant<Column<double>, Column<std::int32_t>>;

/// One field of a mesh. Symmetric tensors have their components in the order of `Sym`, full tensors row by row.
struct MeshField {
    std::string name;
    Centring centring = Centring::node;
    FieldKind kind = FieldKind::scalar;
    FieldValues values;

    [[nodiscard]] std::size_t size() const {
        return std::visit([](const auto& column) { return column.size(); }, values);
    }
    friend bool operator==(const MeshField&, const MeshField&) = default;
};

/// Named fields of one mesh in D dimensions, no name twice for a centring: a value; `with` gives another.
class MeshFields {
  public:
    MeshFields() = default;
    /// All of them at once, which is as one after the other `with` the others, but takes no longer than to sort them.
    explicit MeshFields(std::vector<MeshField> fields);

    /// These fields and one more; one of the same name and centring is replaced.
    [[nodiscard]] MeshFields with(MeshField field) && {
        for (MeshField& old : fields_)
            if (old.name == field.name && old.centring == field.centring) {
                old = std::move(field);
                return std::move(*this);
            }
        fields_.push_back(std::move(field));
        return std::move(*this);
    }
    [[nodiscard]] MeshFields with(MeshField field) const& { return MeshFields(*this).with(std::move(field)); }

    [[nodiscard]] const MeshField* find(std::string_view name, Centring centring) const {
        for (const MeshField& field : fields_)
            if (field.name == name && field.centring == centring) return &field;
        return nullptr;
    }
    [[nodiscard]] auto begin() const { return fields_.begin(); }
    [[nodiscard]] auto end() const { return fields_.end(); }
    [[nodiscard]] std::size_t size() const { return fields_.size(); }
    [[nodiscard]] bool empty() const { return fields_.empty(); }
    friend bool operator==(const MeshFields&, const MeshFields&) = default;

  private:
    std::vector<MeshField> fields_;
};

/// The fields at nodes as a solution at the first `vertices` nodes, for files beside a mesh of that dimension; fields
/// at cells and the values at edges' nodes are left out. Errors: usage (none of the fields is at nodes).
[[nodiscard]] Outcome<Solution> solution_of(const MeshFields& fields, int dimension, std::size_t vertices,
                                            const Execution& execution);

}  // namespace camber
