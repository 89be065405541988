// What the cad module asks of the library that knows CAD files: plain C++, without names of the modules, since its
// makers are compiled into a library of their own, which is loaded at the first use (docs/algorithms/cad.md).
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace camber::occ {

using Point = std::array<double, 3>;

/// The point of a surface at (u, v), and its derivatives.
struct SurfaceJet {
    Point point, u, v, uu, uv, vv;
};
/// The point of a curve at t, and its derivatives.
struct CurveJet {
    Point point, first, second;
};

/// A surface to which distances have a closed form, in the unit of the file: z along its axis or normal, x where u is
/// 0.
struct ClosedForm {
    enum class Kind { none, plane, cylinder, sphere, torus };
    Kind kind = Kind::none;
    Point origin{}, x{}, y{}, z{};
    double major = 0, minor = 0;  ///< radii; of a cylinder and a sphere the first alone
    double scale = 1;             ///< of that unit, in the one in which the kernel answers
};

struct FaceFacts {
    bool is_plane = false;
    bool has_closed_form = false;      ///< nearest_parameters answers
    ClosedForm form = {};              ///< of the same surfaces
    bool is_reversed = false;          ///< the face's outward normal is −u × v
    std::array<double, 2> low, high;   ///< of the parameters on the face
    std::array<double, 2> period{};    ///< 0: none
    std::array<std::size_t, 2> cells;  ///< so many parts each way that a search from their middles misses nothing
    std::vector<std::size_t> edges;    ///< those around it that are curves, each once
};

struct EdgeFacts {
    bool is_line = false;
    double first = 0, last = 0, period = 0;
    std::size_t cells = 1;
    std::vector<std::size_t> vertices;  ///< its ends, one where it is closed
    std::vector<std::size_t> faces;     ///< around it, each once
    double turn = half_turn;            ///< largest angle between the outward normals of its two faces (radians)

    static constexpr double half_turn = 3.141592653589793;  ///< also of an edge that has not two faces
};

/// What a file has and the model made of it has not.
struct Losses {
    std::size_t faces = 0;        ///< that no face could be made of
    std::size_t entities = 0;     ///< whose transfer failed
    std::size_t open_shells = 0;  ///< of solids
};

/// An immutable model, asked by any number of threads.
class Kernel {
  public:
    Kernel() = default;
    Kernel(const Kernel&) = delete;
    Kernel& operator=(const Kernel&) = delete;
    virtual ~Kernel() = default;

    std::vector<FaceFacts> faces;
    std::vector<EdgeFacts> edges;
    std::vector<Point> vertices;
    std::string file_unit;   ///< as the file calls it; empty: it says none
    double millimetres = 1;  ///< of the unit in which it answers
    double file_millimetres = 1;
    Losses losses;

    /// The model for another process: `Restore` makes the same of it, to the last bit.
    [[nodiscard]] virtual std::string packed() const = 0;
    /// Of points and derivatives: no numbers where there are none.
    [[nodiscard]] virtual SurfaceJet on_surface(std::size_t face, double u, double v) const = 0;
    [[nodiscard]] virtual CurveJet on_curve(std::size_t edge, double t) const = 0;
    /// Of the point of the whole surface, not only of the face, that is nearest to p.
    [[nodiscard]] virtual std::array<double, 2> nearest_parameters(std::size_t face, const Point& p) const = 0;
    /// Whether the face has the point of its surface at (u, v), where that is known without OpenCASCADE.
    [[nodiscard]] virtual std::optional<bool> has_at_once(std::size_t face, double u, double v) const = 0;
    /// Whether the face has the point of its surface at (u, v).
    [[nodiscard]] virtual bool has(std::size_t face, double u, double v) const = 0;
};

/// What the file is, by its ending.
enum class Format { step, iges, brep };

struct Opened {
    std::unique_ptr<Kernel> kernel;
    std::string fault, remedy;  ///< why there is none
    bool is_out_of_memory = false;
};

/// `millimetres`: of the unit that coordinates are wanted in; 0: that of the file.
using Open = void(const char* path, Format format, double millimetres, Opened& opened);
/// Of what `packed` gave.
using Restore = void(const std::string& bytes, double millimetres, Opened& opened);

}  // namespace camber::occ

/// The functions of the library.
extern "C" __attribute__((visibility("default"))) void camber_occ_open(const char* path, camber::occ::Format format,
                                                                       double millimetres, camber::occ::Opened& opened);
extern "C" __attribute__((visibility("default"))) void camber_occ_restore(const std::string& bytes, double millimetres,
                                                                          camber::occ::Opened& opened);
