// Builds a mesh from the arrays of a VTU file.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::vtu {

namespace {

/// Names of cell arrays with references, in lower case and without punctuation. The first one that occurs is used.
constexpr std::array<std::string_view, 26> names_of_references{
    "reference", "meditref",   "gmshphysical", "cellentityids",  "materialid",     "materialids", "material",
    "matid",     "attribute",  "attributes",   "region",         "regionid",       "regionids",   "regions",
    "subdomain", "subdomains", "domain",       "physical",       "physicalid",     "physicalids", "celltags",
    "facettags", "celltag",    "blockid",      "elementblockid", "gmshgeometrical"};

std::string plain_name(std::string_view name) {
    std::string plain;
    for (const char c : name) {
        if (c >= 'A' && c <= 'Z') plain += static_cast<char>(c - 'A' + 'a');
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) plain += c;
    }
    return plain;
}

auto damaged(const File& file, std::size_t at, std::string what) {
    return fail(ErrorKind::input, std::move(what), place(file, at), {},
                "the file is damaged, or was joined from two "
                "files");
}

Outcome<Numbers> read_rows(const File& file, const DataArray& array, std::size_t rows, const Execution& execution) {
    auto numbers = read_array(file, array, rows, execution);
    if (!numbers) return numbers;
    const std::size_t size = size_of(*numbers);
    if (array.components == 0 || size % array.components != 0 || size / array.components != rows)
        return damaged(file, array.at,
                       "the array " + array.name + " has " + std::to_string(size) + " numbers, not " +
                           std::to_string(array.components) + " for each of " + std::to_string(rows) + " rows");
    return numbers;
}

std::optional<FieldKind> kind_with(std::size_t components) {
    switch (components) {
        case 1: return FieldKind::scalar;
        case 3: return FieldKind::vector;
        case 6: return FieldKind::symmetric_tensor;
        case 9: return FieldKind::full_tensor;
        default: return std::nullopt;
    }
}

struct DroppedArrays {
    const char* reason;
    std::size_t count = 0;
    std::string names = {};

    void add(const std::string& input) {
        const std::string name = printable(input);
        constexpr std::size_t most = 5;
        if (count < most) names += (count == 0 ? "" : ", ") + name.substr(0, 80);
        if (count++ == most) names += " …";
    }
    void add_notices(std::vector<Notice>& notices) const {
        if (count > 0)
            notices.push_back({std::to_string(count) + " arrays were left out, since " + reason + ": " + names});
    }
};

/// Returns the last array of each name, as VTK does. Earlier arrays are listed in `repeated`.
std::vector<const DataArray*> last_of_names(std::span<const DataArray> arrays, DroppedArrays& repeated) {
    std::map<std::string_view, const DataArray*> last;
    for (const DataArray& array : arrays) last.insert_or_assign(array.name, &array);
    std::vector<const DataArray*> selected;
    for (const DataArray& array : arrays)
        if (array.name.empty() || last.at(array.name) == &array)
            selected.push_back(&array);
        else
            repeated.add(array.name);
    return selected;
}

class MeshReader {
  public:
    MeshReader(const File& file, const DecodeOptions& options, const Execution& execution)
        : file_(file), options_(options), execution_(execution) {
        mesh_.name = file.name;
    }

    Outcome<ListedPieces> read() && {
        auto points = read_points(file_, execution_);
        if (!points) return fail(std::move(points.error()));
        mesh_.points = std::move(*points);
        auto cells = read_cells(file_, options_.unsupported_cells, notices_, execution_);
        if (!cells) return fail(std::move(cells.error()));
        cells_ = std::move(*cells);
        for (auto part : {&MeshReader::nodes, &MeshReader::point_data, &MeshReader::cell_data}) {
            auto done = (this->*part)();
            if (!done) return fail(std::move(done.error()));
        }
        mesh_.fields = MeshFields(std::move(fields_));
        auto sound = listing::check(mesh_, execution_);
        if (sound && file_.pieces.size() > 1) sound = join_pieces();
        if (!sound) return fail(std::move(sound.error()));
        add_notices();
        return ListedPieces{std::move(mesh_), std::move(notices_), std::move(cells_.unsupported_cells)};
    }

  private:
    Outcome<Done> join_pieces() {
        std::vector<std::size_t> ends;
        ends.reserve(file_.pieces.size());
        for (const PieceSize& piece : file_.pieces) ends.push_back((ends.empty() ? 0 : ends.back()) + piece.points);
        const std::size_t joined = listing::join_coincident(mesh_, ends);
        notices_.push_back({std::to_string(ends.size()) + " pieces were joined into one mesh, at " +
                            std::to_string(joined) + " points"});
        return listing::check(mesh_, execution_);
    }

    Outcome<Done> nodes() { return place_cells(file_, cells_, mesh_, execution_); }

    Outcome<Done> point_data() {
        mesh_.point_references = Buffer<Reference>(mesh_.points.size(), 0);
        for (const DataArray* const array : last_of_names(file_.point_data, repeated_)) {
            auto done = array->name == "reference" ? references_of_points(*array) : field(*array, Centring::node);
            if (!done) return done;
        }
        return Done{};
    }

    Outcome<Done> references_of_points(const DataArray& array) {
        return whole_scalars(array, file_.points).map([&](std::optional<Buffer<Reference>> references) {
            if (references) mesh_.point_references = std::move(*references);
            return Done{};
        });
    }

    Outcome<Done> cell_data() {
        const auto arrays = last_of_names(file_.cell_data, repeated_);
        auto references = references_of_cells(arrays);
        if (!references) return fail(std::move(references.error()));
        Buffer<Reference> entities;
        for (const DataArray* const array : arrays) {
            if (array == array_of_references_ || array->name == ghost_array) continue;
            auto done = array->name == "entity"      ? entities_of_cells(*array, entities)
                        : array->name == "dimension" ? dimensions(*array)
                        : array->name == "reference" ? Outcome<Done>(Done{})
                                                     : field(*array, Centring::cell);
            if (!done) return done;
        }
        std::size_t kind = 0;
        const auto take = [&](auto& simplices) {
            const auto& curved = cells_.of_kind[kind++];
            const auto& straight = cells_.of_kind[kind++];
            simplices.curved.references = chosen(*references, curved);
            simplices.straight.references = chosen(*references, straight);
            Buffer<Reference> of_curved = chosen(entities, curved), of_straight = chosen(entities, straight);
            const auto known = [](Reference e) { return e != 0; };
            if (std::any_of(of_curved.begin(), of_curved.end(), known) ||
                std::any_of(of_straight.begin(), of_straight.end(), known)) {
                simplices.curved.entities = std::move(of_curved);
                simplices.straight.entities = std::move(of_straight);
            }
        };
        take(mesh_.elements);
        take(mesh_.facets);
        take(mesh_.edges);
        return Done{};
    }

    Outcome<Buffer<Reference>> references_of_cells(std::span<const DataArray* const> arrays) {
        if (!options_.reference_array.empty()) return requested_references(arrays);
        for (const std::string_view name : names_of_references)
            for (const DataArray* const array : arrays) {
                if (plain_name(array->name) != name) continue;
                auto references = whole_scalars(*array, file_.cells);
                if (!references) return fail(std::move(references.error()));
                if (!*references) continue;
                array_of_references_ = array;
                constexpr std::size_t min_references = 5;
                if (std::ranges::find(names_of_references, name) - names_of_references.begin() >=
                    static_cast<std::ptrdiff_t>(min_references))
                    notices_.push_back({"the references of the cells are the array " + printable(array->name)});
                return std::move(**references);
            }
        return Buffer<Reference>(file_.cells, 0);
    }

    Outcome<Buffer<Reference>> requested_references(std::span<const DataArray* const> arrays) {
        std::string names;
        for (const DataArray* const array : arrays) {
            names += (names.empty() ? "" : ", ") + printable(array->name);
            if (array->name != options_.reference_array) continue;
            auto references = whole_scalars(*array, file_.cells);
            if (!references) return fail(std::move(references.error()));
            if (!*references) break;
            array_of_references_ = array;
            return std::move(**references);
        }
        return fail(ErrorKind::input,
                    "no array of cells " + in_quotes(options_.reference_array) + " has a 32-bit integer for each cell",
                    file_.name, {}, names.empty() ? "it has no arrays of cells" : "its arrays of cells are " + names);
    }

    Outcome<Done> entities_of_cells(const DataArray& array, Buffer<Reference>& entities) {
        return whole_scalars(array, file_.cells).map([&](std::optional<Buffer<Reference>> result) {
            if (result) entities = std::move(*result);
            return Done{};
        });
    }

    /// Reads the array `dimension`, which is redundant if it has the dimensions of the cells; otherwise it is dropped
    /// with a notice.
    Outcome<Done> dimensions(const DataArray& array) {
        auto numbers = whole_scalars(array, file_.cells);
        if (!numbers) return fail(std::move(numbers.error()));
        bool is_own = numbers->has_value();
        for (std::size_t kind = 0; kind < Cells::kinds && is_own; ++kind)
            for (const std::uint32_t cell : cells_.of_kind[kind])
                is_own = is_own && (**numbers)[cell] == Cells::dimension(kind);
        if (!is_own) taken_names_.add(array.name);
        return Done{};
    }

    Outcome<std::optional<Buffer<Reference>>> whole_scalars(const DataArray& array, std::size_t rows) {
        const auto none = [&]() -> std::optional<Buffer<Reference>> {
            if (array.name == "reference" || array.name == "entity") taken_names_.add(array.name);
            return std::nullopt;
        };
        if (array.components != 1 || !is_number(array)) return none();
        const auto numbers = read_rows(file_, array, rows, execution_);
        if (!numbers) return fail(numbers.error());
        auto result = as_references(*numbers, execution_);
        if (!result || *result) return result;
        return none();
    }

    Outcome<Done> field(const DataArray& array, Centring centring) {
        const auto kind = kind_with(array.components);
        if (!is_number(array)) return left_out(no_numbers_, array);
        if (array.name.empty()) return left_out(nameless_, array);
        if (!kind) return left_out(other_components_, array);
        const bool cells = centring == Centring::cell;
        const auto numbers = read_rows(file_, array, cells ? file_.cells : file_.points, execution_);
        if (!numbers) return fail(numbers.error());
        auto values =
            field_values(*numbers, cells ? &cells_.order : nullptr, components_of(*kind, 3).sources, execution_);
        if (!values) return fail(std::move(values.error()));
        fields_.push_back({array.name, centring, *kind, std::move(*values)});
        return Done{};
    }

    static Outcome<Done> left_out(DroppedArrays& list, const DataArray& array) {
        list.add(array.name);
        return Done{};
    }

    [[nodiscard]] static Buffer<Reference> chosen(const Buffer<Reference>& of_file,
                                                  const Column<std::uint32_t>& cells) {
        Buffer<Reference> result;
        if (of_file.empty()) return result;
        result.reserve(cells.size());
        for (const std::uint32_t cell : cells) result.push_back(of_file[cell]);
        return result;
    }

    void add_notices() {
        for (const DroppedArrays* list : {&repeated_, &no_numbers_, &nameless_, &other_components_, &taken_names_})
            list->add_notices(notices_);
        if (file_.field_data_arrays > 0)
            notices_.push_back({std::to_string(file_.field_data_arrays) + " arrays of FieldData were left out"});
    }

    const File& file_;
    const DecodeOptions& options_;
    const Execution& execution_;
    listing::Mesh<3> mesh_;
    Cells cells_;
    std::vector<MeshField> fields_;
    std::vector<Notice> notices_;
    const DataArray* array_of_references_ = nullptr;
    DroppedArrays repeated_{"a later array has the same name"}, no_numbers_{"they are not numeric"},
        nameless_{"they have no name"}, other_components_{"they have neither 1, 3, 6 nor 9 components"},
        taken_names_{"their values differ from those that Camber writes under these names"};
};

}  // namespace

Outcome<ListedPieces> listing_of(const File& file, const DecodeOptions& options, const Execution& execution) {
    return MeshReader(file, options, execution).read();
}

Outcome<DecodedMesh> mesh_of(const File& file, const DecodeOptions& options, const Execution& execution) {
    auto listed = listing_of(file, options, execution);
    if (!listed) return fail(std::move(listed.error()));
    auto decoded = listing::assembled(std::move(listed->mesh), listing::MidNodeKind::on_curve,
                                      std::move(listed->notices), execution);
    if (decoded) decoded->unsupported_cells = std::move(listed->unsupported_cells);
    return decoded;
}

}  // namespace camber::vtu

namespace camber {

Outcome<DecodedMesh> decode_vtu(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        const auto file = vtu::open_file(bytes, name);
        if (!file) return fail(file.error());
        if (auto sound = vtu::check_sizes(*file); !sound) return fail(std::move(sound.error()));
        return vtu::mesh_of(*file, options, execution);
    });
}

}  // namespace camber
