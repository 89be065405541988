// Models made by OpenCASCADE and written to files. Names of Camber's modules do not occur here, because they conflict
// with OpenCASCADE's headers.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace cad_tests {

enum class Kind {
    box,           // sizes a, b, c from the origin
    ball,          // radius a about the origin
    shell,         // between spheres of radii a (inner) and b about the origin
    cylinder,      // radius a, from z = 0 to b
    cone,          // radius a at z = 0 to b at z = c
    torus,         // radii a, b about z
    half_torus,    // the part of a torus on one side of a plane through z
    filleted_box,  // edges of a box of size a rounded by b
    nurbs_torus,   // torus, as rational splines
    nurbs_ball,
    revolved_ball,  // as a rational spline turned about z
    two_boxes,      // sizes a, b, c side by side along x, each with its own face where they touch
    annulus,        // a plane face between circles of radii a (inner) and b about the origin, at z = c
    circles,        // the two circles of the annulus only
    ellipse,        // a plane face within half axes a, b
    spline,         // a plane face within a closed cubic spline around the origin, about radius a
    half_disc,      // a plane face of radius a where y > 0
    plate,          // a box from (-1, -1, 0) to (1, 1, 1/2) with a hole of radius 1/2 along z
    // Cut obliquely, so that the parameter range of a face extends far beyond its edges:
    tilted_hole,  // a unit box with a hole of radius a at an angle b
    cap,          // part of a ball of radius a, cut by a plane at an angle b
    groove,       // a box of sizes 4, 4, 1 with a groove from a torus of radii a, b in its upper face
    skew_cone,    // a cone of radii a, b and height c, cut by a tilted plane
    // Split into faces that meet smoothly, one of them a sliver:
    split_cylinder,  // radius a, from z = 0 to b, cut by three half planes through z; the sliver's angle is c
    split_disc,      // a plane face of radius a within three arcs; the sliver's angle is b
    nothing,         // a shape without faces
};

/// The triangles of a model, each face with vertices of its own.
struct Triangles {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<std::size_t, 3>> triangles;
    std::vector<int> faces;  ///< face number of each triangle, from 1
};
[[nodiscard]] Triangles triangles_of(Kind kind, const std::array<double, 3>& sizes, double deflection);

/// A temporary file, removed by the destructor.
class File {
  public:
    explicit File(const std::string& ending);
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File();
    [[nodiscard]] const std::string& path() const { return path_; }

  private:
    std::string path_;
};

/// Writes a model. `unit` is a STEP unit: MM, M, INCH; lengths are millimetres and are converted to it.
void write_model(Kind kind, const std::array<double, 3>& sizes, const File& file, const char* unit = "MM");

}  // namespace cad_tests
