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

/// The library, loaded at the first use.
[[nodiscard]] const Library& library();
/// The library lets one thread in at a time.
[[nodiscard]] std::mutex& library_lock();

/// CGNS has names of at most 32 letters.
using Name = std::array<char, 33>;

/// Where a simplex of the file went.
struct Place {
    std::int8_t dimension = -1, degree = 0;
    bool listed = false;  ///< by a boundary condition
    std::uint32_t row = 0;
};

/// Elements with numbers that follow each other.
struct Section {
    std::string name;
    std::optional<Reference> reference = {};  ///< as the file gives it
    cgsize_t first = 0;
    std::vector<Place> places = {};
};

/// A file of D physical dimensions while it is read, and what was found in it.
template <int D>
struct Reader {
    const Library& lib;
    int file = 0;
    int cell_dimension = 0;
    UnpackedBudget budget = UnpackedBudget(0);  ///< what counts announce: nothing is reserved beyond it
    int zone = 1;                               ///< that is read, as all below but the mesh
    std::size_t first_point = 0;                ///< of the zone, in the mesh
    std::size_t groups_before = 0;              ///< of earlier zones
    std::string prefix = {};                    ///< of names of the elements' groups, where several zones are joined
    std::vector<Section> sections = {};
    listing::Mesh<D> mesh = {};
    std::vector<Notice> notices = {};
    Refused refused = {};
    std::size_t points_listed = 0;  ///< elements that are vertices

    [[nodiscard]] std::size_t zone_points() const { return mesh.points.size() - first_point; }
    /// The vertex of the mesh; none where the zone has none of that number.
    [[nodiscard]] VertexId vertex(cgsize_t number) const {
        if (number < 1 || !std::cmp_less_equal(number, zone_points())) return VertexId();
        return VertexId(first_point + static_cast<std::size_t>(number - 1));
    }
    /// The number of the group of that name, of an earlier zone.
    [[nodiscard]] std::optional<Reference> known_reference(int dimension, const std::string& name) const {
        for (std::size_t g = 0; g < groups_before; ++g)
            if (mesh.groups[g].dimension == dimension && mesh.groups[g].name == name) return mesh.groups[g].reference;
        return std::nullopt;
    }

    [[nodiscard]] auto broken(std::string_view doing) const {
        return fail(error_of(lib.get_error_(), ErrorKind::input, doing, mesh.name));
    }

    /// Before so many numbers are reserved. Errors: input (the file cannot hold them).
    [[nodiscard]] Outcome<Done> announced(std::size_t numbers, const std::string& what) {
        if (budget.take(numbers)) return Done{};
        return fail(ErrorKind::input, what + ": more numbers are announced than a file of this size holds", mesh.name,
                    {}, "the file is damaged; if it is whole, write it uncompressed");
    }

    /// The number that a descriptor below the current node gives.
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

/// Whether the nodes of a file of so many bytes announce no more than is believed of it (UnpackedBudget): data in HDF5
/// may be compressed, or there although nobody wrote them. Errors: input (they do, they are nested without end).
[[nodiscard]] Outcome<Done> check_nodes(const Library& lib, const std::string& path, std::size_t file_bytes,
                                        const std::string& name);

/// Simplices of all sections, with references 0. Errors: input, unsupported (cells that are no simplices).
template <int D>
[[nodiscard]] Outcome<Done> read_sections(Reader<D>& of);

/// The references of simplices: those of boundary conditions, then those of sections. Errors: input.
template <int D>
[[nodiscard]] Outcome<Done> read_conditions(Reader<D>& of);

/// Scalars at vertices; those named …X …Y (…Z) become a vector. Errors: input.
template <int D>
[[nodiscard]] Outcome<Done> read_fields(Reader<D>& of);

}  // namespace camber::cgns
