// Interface between the cad module and OpenCASCADE, in plain C++ without modules: the implementation is a separate
// library, loaded at first use (docs/algorithms/cad.md).
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace camber::occ {

using Point = std::array<double, 3>;

struct SurfaceJet {
    Point point, u, v, uu, uv, vv;
};
struct CurveJet {
    Point point, first, second;
};

/// A surface with closed-form distances, in millimetres. z is along the axis or normal of the surface, x points to u =
/// 0.
struct ClosedForm {
    enum class Kind { none, plane, cylinder, sphere, torus };
    Kind kind = Kind::none;
    Point origin{}, x{}, y{}, z{};
    double major = 0, minor = 0;  ///< radii; cylinder and sphere use only `major`
    double scale = 1;             ///< factor from millimetres to the kernel's unit
};

struct FaceFacts {
    bool is_plane = false;
    bool has_closed_form = false;      ///< `Kernel::nearest_parameters` is available
    ClosedForm form = {};              ///< set if `has_closed_form`
    bool is_reversed = false;          ///< the outward normal is −u × v, with u and v of `SurfaceJet`
    std::array<double, 2> low, high;   ///< parameter bounds
    std::array<double, 2> period{};    ///< 0: not periodic
    std::array<std::size_t, 2> cells;  ///< number of search cells per direction; searches from the middles of all cells
                                       ///< find all minima
    std::vector<std::size_t> edges;    ///< distinct edges with curves
};

struct EdgeFacts {
    bool is_line = false;
    double first = 0, last = 0, period = 0;
    std::size_t cells = 1;
    std::vector<std::size_t> vertices;  ///< end vertices; one if the edge is closed
    std::vector<std::size_t> faces;     ///< distinct adjacent faces
    double turn = half_turn;            ///< largest angle between the outward normals of the edge's two faces (radians)

    static constexpr double half_turn = 3.141592653589793;  ///< value of `turn` if the edge does not have two faces
                                                            ///< with normals
};

struct Losses {
    std::size_t faces = 0;
    std::size_t entities = 0;
    std::size_t open_shells = 0;
};

/// An immutable, thread-safe CAD model.
class Kernel {
  public:
    Kernel() = default;
    Kernel(const Kernel&) = delete;
    Kernel& operator=(const Kernel&) = delete;
    virtual ~Kernel() = default;

    std::vector<FaceFacts> faces;
    std::vector<EdgeFacts> edges;
    std::vector<Point> vertices;
    std::string file_unit;   ///< unit's name in the file; empty: none
    double millimetres = 1;  ///< length of the coordinate unit
    double file_millimetres = 1;
    Losses losses;

    /// Model as bytes for `Restore` in another process, bitwise exact.
    [[nodiscard]] virtual std::string packed() const = 0;
    [[nodiscard]] virtual SurfaceJet on_surface(std::size_t face, double u, double v) const = 0;
    [[nodiscard]] virtual CurveJet on_curve(std::size_t edge, double t) const = 0;
    /// Parameters of the closest point on the untrimmed surface.
    [[nodiscard]] virtual std::array<double, 2> nearest_parameters(std::size_t face, const Point& p) const = 0;
    /// True if the point at (u, v) is on the face; empty if only OpenCASCADE can decide.
    [[nodiscard]] virtual std::optional<bool> has_if_known(std::size_t face, double u, double v) const = 0;
    [[nodiscard]] virtual bool has(std::size_t face, double u, double v) const = 0;
};

enum class Format { step, iges, brep };

struct Opened {
    std::unique_ptr<Kernel> kernel;
    std::string error_text, remedy;  ///< reason of a failure, and its remedy
    bool is_out_of_memory = false;
};

/// Opens a file. `millimetres`: length of the coordinate unit; 0: the file's unit.
using Open = void(const char* path, Format format, double millimetres, Opened& opened);
using Restore = void(const std::string& bytes, double millimetres, Opened& opened);

}  // namespace camber::occ

extern "C" __attribute__((visibility("default"))) void camber_occ_open(const char* path, camber::occ::Format format,
                                                                       double millimetres, camber::occ::Opened& opened);
extern "C" __attribute__((visibility("default"))) void camber_occ_restore(const std::string& bytes, double millimetres,
                                                                          camber::occ::Opened& opened);
