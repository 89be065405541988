module;
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>
export module camber.cad:model;
import camber.core;

namespace camber {
/// What a model is made of: the library's kernel, and what searches begin with.
struct CadParts;
}  // namespace camber

export namespace camber {

/// The length that is 1 in a mesh. `automatic`: found by the mesh's boundary (in_unit_of); a model that is read
/// without a mesh is in the unit of its file.
enum class CadUnit : std::uint8_t { automatic, file, m, cm, mm, um, in, ft };
[[nodiscard]] constexpr auto words(CadUnit) {
    return words_of(Word{CadUnit::automatic, "auto"}, Word{CadUnit::file, "file"}, Word{CadUnit::m, "m"},
                    Word{CadUnit::cm, "cm"}, Word{CadUnit::mm, "mm"}, Word{CadUnit::um, "um"}, Word{CadUnit::in, "in"},
                    Word{CadUnit::ft, "ft"});
}
/// Millimetres of a unit; 0: the unit of the file.
[[nodiscard]] constexpr double millimetres_of(CadUnit unit) {
    switch (unit) {
        case CadUnit::automatic:
        case CadUnit::file: return 0;
        case CadUnit::m: return 1000;
        case CadUnit::cm: return 10;
        case CadUnit::mm: return 1;
        case CadUnit::um: return 1e-3;
        case CadUnit::in: return 25.4;
        case CadUnit::ft: return 304.8;
    }
    return 0;
}

struct CadOptions {
    CadUnit unit = CadUnit::automatic;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("unit", &CadOptions::unit,
                                 "the unit of the mesh's coordinates, to which the model is converted; auto: that of "
                                 "the file if the mesh's boundary lies on the model in it, else the only unit in which "
                                 "it does; file: coordinates are as the file has them"));
    }
    friend bool operator==(const CadOptions&, const CadOptions&) = default;
};

/// What a file has and the model made of it has not.
struct CadLosses {
    std::size_t faces = 0;        ///< that no face could be made of
    std::size_t entities = 0;     ///< whose transfer failed
    std::size_t open_shells = 0;  ///< of solids
};

/// A CAD model, an immutable value that any number of threads may ask. Faces, edges and vertices are numbered from 0 in
/// the order in which a walk through the file's shape meets them first; edges without a curve (at the pole of a sphere)
/// are left out.
class CadModel {
  public:
    explicit CadModel(std::shared_ptr<const CadParts> parts);

    [[nodiscard]] std::size_t faces() const;
    [[nodiscard]] std::size_t edges() const;
    [[nodiscard]] std::size_t vertices() const;
    [[nodiscard]] Box<3> bounds() const;
    [[nodiscard]] Vec<3> vertex(std::size_t vertex) const;
    /// As the file calls it; empty: it says none.
    [[nodiscard]] std::string file_unit() const;
    /// The unit of the model's coordinates: its word in CadUnit, else as the file calls it.
    [[nodiscard]] std::string unit() const;
    /// Whether the coordinates are as the file has them.
    [[nodiscard]] bool is_in_file_unit() const;
    [[nodiscard]] CadLosses losses() const;

    [[nodiscard]] const CadParts& parts() const { return *parts_; }

  private:
    std::shared_ptr<const CadParts> parts_;
};

/// Whether this build of Camber can read CAD files at all.
[[nodiscard]] bool knows_cad();

/// The endings of files that are read, as messages list them.
inline constexpr std::string_view cad_endings = ".step, .stp, .iges, .igs or .brep";

/// The model of a file: STEP, IGES or BREP, by its ending. (The reader takes a path, not bytes: so does the library
/// that it stands on.) Faces of an IGES file are sewn together at edges that coincide within 1e-5 of the size. A file
/// that says no unit counts as one in millimetres. Errors: of another ending (usage); OpenCASCADE is not there
/// (unsupported); broken, or without a face and without an edge (input).
/// The library may crash, run without end or take all memory on a file that is damaged: where that matters, read in
/// another process and hand the model over by the two below, as the program does.
[[nodiscard]] Outcome<CadModel> read_cad(const std::string& path, const CadOptions& options);

/// A model as bytes, and the model of such bytes: the same, to the last bit, in any unit. They are for a process of the
/// same version. Errors: of the second, as of read_cad.
[[nodiscard]] Outcome<std::string> packed_cad(const CadModel& model);
[[nodiscard]] Outcome<CadModel> unpacked_cad(const std::string& bytes, const CadOptions& options);

/// The same model in another unit. Errors: as of unpacked_cad.
[[nodiscard]] Outcome<CadModel> in_unit(const CadModel& model, CadUnit unit);

}  // namespace camber
