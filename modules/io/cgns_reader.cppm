module;
#include "cgns_library.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io:cgns_reader;
import camber.core;
import camber.bezier;
import :gmf_file;
import :listing;
import :meshes;
import :other_formats;
import :text;

namespace camber::cgns {

/// The first call loads the library.
[[nodiscard]] const Library& library();
/// Mutex that every call of the library locks, because the library is not thread-safe.
[[nodiscard]] std::mutex& library_lock();

using Name = std::array<char, 33>;

struct Place {
    std::int8_t dimension = -1, degree = 0;
    bool listed = false;
    std::uint32_t row = 0;
};

/// A section of the file: elements with consecutive numbers from `first`.
struct Section {
    std::string name;
    std::optional<Reference> reference = {};
    cgsize_t first = 0;
    std::vector<Place> places = {};
};

/// D: number of coordinates of a point.
template <int D>
struct Reader {
    const Library& lib;
    int file = 0;
    int cell_dimension = 0;
    UnpackedBudget budget = UnpackedBudget(0);  ///< limits the total count of numbers that the file declares
    int zone = 1;                               ///< current zone; the members below, up to `sections`, belong to it
    std::size_t first_point = 0;                ///< the zone's first point has this number in the mesh
    std::size_t groups_before = 0;              ///< number of groups that earlier zones have added
    std::string prefix = {};                    ///< prefix of the names of element groups if zones are joined
    std::vector<Section> sections = {};
    listing::Mesh<D> mesh = {};
    std::vector<Notice> notices = {};
    UnsupportedItems refused = {};
    std::size_t points_listed = 0;

    [[nodiscard]] std::size_t zone_points() const { return mesh.points.size() - first_point; }
    /// Vertex with this number in the zone, from 1; an invalid id if there is none.
    [[nodiscard]] VertexId vertex(cgsize_t number) const {
        if (number < 1 || !std::cmp_less_equal(number, zone_points())) return VertexId();
        return VertexId(first_point + static_cast<std::size_t>(number - 1));
    }
    /// Reference of the group with this name in an earlier zone.
    [[nodiscard]] std::optional<Reference> known_reference(int dimension, const std::string& name) const {
        for (std::size_t g = 0; g < groups_before; ++g)
            if (mesh.groups[g].dimension == dimension && mesh.groups[g].name == name) return mesh.groups[g].reference;
        return std::nullopt;
    }

    [[nodiscard]] auto broken(std::string_view doing) const {
        return fail(error_of(lib.get_error_(), ErrorKind::input, doing, mesh.name));
    }

    /// Reserves budget for `numbers` numbers before their memory is allocated.
    [[nodiscard]] Outcome<Done> take_budget(std::size_t numbers, const std::string& what) {
        if (budget.take(numbers)) return Done{};
        return fail(ErrorKind::input, what + ": the file declares more numbers than a file of this size can contain",
                    mesh.name, {}, "the file is damaged; if it is whole, write it uncompressed");
    }

    /// Value of the descriptor named `reference` at the library's current node.
    [[nodiscard]] std::optional<Reference> described_reference() const {
        int n = 0;
        if (lib.ndescriptors_(&n) != CG_OK) return std::nullopt;
        for (int d = 1; d <= n; ++d) {
            Name name{};
            char* text = nullptr;
            if (lib.descriptor_read_(d, name.data(), &text) != CG_OK) continue;
            const std::string value(text != nullptr ? text : "");
            if (text != nullptr) lib.free_(text);
            if (std::string_view(name.data()) != "reference") continue;
            Words words{value.data(), value.data() + value.size()};
            std::int64_t number = 0;
            if (read_number(words, number) && gmf::is_reference(number)) return static_cast<Reference>(number);
        }
        return std::nullopt;
    }
};

/// Checks that the declared sizes of all tree nodes stay within UnpackedBudget. They can exceed the file size, because
/// HDF5 data may be compressed, or allocated but never written.
[[nodiscard]] Outcome<Done> check_nodes(const Library& lib, const std::string& path, std::size_t file_bytes,
                                        const std::string& name);

template <int D>
[[nodiscard]] Outcome<Done> read_sections(Reader<D>& of);

template <int D>
[[nodiscard]] Outcome<Done> read_conditions(Reader<D>& of);

/// Reads fields at vertices. Scalars named …X, …Y and (3D) …Z become one vector. Errors: input.
template <int D>
[[nodiscard]] Outcome<Done> read_fields(Reader<D>& of);

}  // namespace camber::cgns
