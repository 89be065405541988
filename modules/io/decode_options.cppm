module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
export module camber.io:decode_options;
import camber.core;

export namespace camber {

/// What is done about a file's cells that no mesh here holds: those that are no simplices, or of a degree above 2.
enum class Unheld : std::uint8_t {
    refuse,  ///< an error that names them
    count,   ///< they are left out and counted (`DecodedMesh::unheld`): to tell what is in a file
};

/// What a caller may choose of how a mesh file is read; each format takes what is its own.
struct DecodeOptions {
    /// The array of cells that is their reference (VTU, VTK); empty: the first with a name that is known for such.
    std::string reference_array = {};
    /// The zone to read (SU2: its number, CGNS: its name or number); empty: all, joined into one mesh.
    std::string zone = {};
    Unheld unheld = Unheld::refuse;
    /// Reads a file that the mesh's file names, by a path from its folder (PVTU); none: nobody does.
    std::function<Outcome<Buffer<std::byte>>(const std::string& path)> beside = {};
};

/// So many cells of a kind, which is in the plural.
struct CellCount {
    std::string kind;
    std::size_t count = 0;
    friend bool operator==(const CellCount&, const CellCount&) = default;
};

}  // namespace camber
