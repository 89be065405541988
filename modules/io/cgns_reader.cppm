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
/// Locked for every call, because the library is not thread-safe.
[[nodiscard]] std::mutex& library_lock();

using Name = std::array<char, 33>;

struct Place {
    std::int8_t dimension = -1, degree = 0;
    bool listed = false;  ///< listed by a boundary condition
    std::uint32_t row = 0;
};

/// Elements with consecutive numbers.
struct Section {
    std::string name;
    std::optional<Reference> reference = {};
    cgsize_t first = 0;
    std::vector<Place> places = {};
};

/// D is the physical dimension.
template <int D>
struct Reader {
    const Library& lib;
    int file = 0;
    int cell_dimension = 0;
    UnpackedBudget budget = UnpackedBudget(0);  ///< limits the numbers announced by the file
    int zone = 1;                               ///< current zone, to which the next members up to `sections` belong
    std::size_t first_point = 0;                ///< mesh number of the zone's first point
    std::size_t groups_before = 0;              ///< number of groups in earlier zones
    std::string prefix = {};                    ///< of element group names, if zones are joined
    std::vector<Section> sections = {};
    listing::Mesh<D> mesh = {};
    std::vector<Notice> notices = {};
    UnsupportedItems refused = {};
    std::size_t points_listed = 0;  ///< number of point elements

    [[nodiscard]] std::size_t zone_points() const { return mesh.points.size() - first_point; }
    /// `number` counts from 1 in the zone. Invalid if there is no such vertex.
    [[nodiscard]] VertexId vertex(cgsize_t number) const {
        if (number < 1 || !std::cmp_less_equal(number, zone_points())) return VertexId();
        return VertexId(first_point + static_cast<std::size_t>(number - 1));
    }
    /// Reference with this name in an earlier zone.
    [[nodiscard]] std::optional<Reference> known_reference(int dimension, const std::string& name) const {
        for (std::size_t g = 0; g < groups_before; ++g)
            if (mesh.groups[g].dimension == dimension && mesh.groups[g].name == name) return mesh.groups[g].reference;
        return std::nullopt;
    }

    [[nodiscard]] auto broken(std::string_view doing) const {
        return fail(error_of(lib.get_error_(), ErrorKind::input, doing, mesh.name));
    }

    /// Call this before memory is reserved. Errors: input (more numbers than the file can hold).
    [[nodiscard]] Outcome<Done> take_budget(std::size_t numbers, const std::string& what) {
        if (budget.take(numbers)) return Done{};
        return fail(ErrorKind::input, what + ": the file declares more numbers than a file of this size can contain",
                    mesh.name, {}, "the file is damaged; if it is whole, write it uncompressed");
    }

    /// Value of the descriptor `reference` at the current node.
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

/// Checks that nodes announce no more data than UnpackedBudget allows: HDF5 data may be compressed, or allocated but
/// never written. Errors: input (too much data, nodes nested too deeply).
[[nodiscard]] Outcome<Done> check_nodes(const Library& lib, const std::string& path, std::size_t file_bytes,
                                        const std::string& name);

/// Elements get reference 0. Errors: input, unsupported (other cells).
template <int D>
[[nodiscard]] Outcome<Done> read_sections(Reader<D>& of);

/// Takes references from boundary conditions, otherwise from sections. Errors: input.
template <int D>
[[nodiscard]] Outcome<Done> read_conditions(Reader<D>& of);

/// Joins vertex scalars named …X …Y (…Z) to vectors. Errors: input.
template <int D>
[[nodiscard]] Outcome<Done> read_fields(Reader<D>& of);

}  // namespace camber::cgns
