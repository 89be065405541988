module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>
module camber.io:vtu_cells;
import camber.core;
import :any_mesh;
import :decode_options;
import :listing;
import :vtu_file;

namespace camber::vtu {

/// The array that marks cells of other pieces.
inline constexpr std::string_view ghost_array = "vtkGhostType";

/// The cells that a mesh has, and where they stand in the file.
struct Cells {
    static constexpr std::size_t kinds = 6;
    /// By kind: elements, facets, edges, of each those of degree 2 first.
    std::array<Column<std::uint32_t>, kinds> of_kind;
    Column<std::uint32_t> order;         ///< all of them behind one another
    Buffer<std::uint64_t> starts;        ///< of each cell of the file, in `connectivity`; one more for the end
    Buffer<std::uint32_t> connectivity;  ///< points; those of an invalid VertexId are none
    std::size_t at = 0;                  ///< where in the file
    std::vector<CellCount> unheld = {};  ///< kinds that were left out

    /// The dimension of the simplices of a kind.
    [[nodiscard]] static constexpr int dimension(std::size_t kind) { return 3 - static_cast<int>(kind / 2); }
};

/// The mesh as the file lists it, in all its pieces behind one another.
struct Listed {
    listing::Mesh<3> mesh;
    std::vector<Notice> notices = {};
    std::vector<CellCount> unheld = {};  ///< kinds of cells that were left out
};
/// Errors: as decode_vtu.
[[nodiscard]] Outcome<Listed> listing_of(const File& file, const DecodeOptions& options, const Execution& execution);

/// The cells of a file, nodes as they are; vertices among them are left out, with a notice. Errors: input (arrays that
/// contradict each other), unsupported (cells that are no simplices, or of another degree than 1 and 2).
[[nodiscard]] Outcome<Cells> read_cells(const File& file, Unheld unheld, std::vector<Notice>& notices,
                                        const Execution& execution);

/// Puts the nodes of the cells into the mesh.
[[nodiscard]] Outcome<Done> place_cells(const File& file, const Cells& cells, listing::Mesh<3>& mesh,
                                        const Execution& execution);

}  // namespace camber::vtu
