// Models that OpenCASCADE makes, written to files. No names of the modules here: its headers must not meet them.
#pragma once

#include <array>
#include <filesystem>
#include <string>

namespace cad_tests {

enum class Kind {
    box,           // sizes a, b, c from the origin
    ball,          // radius a about the origin
    shell,         // between spheres of radii a (inner) and b about the origin
    cylinder,      // radius a, from z = 0 to b
    cone,          // radius a at z = 0 to b at z = c
    torus,         // radii a, b about z
    half_torus,    // of it what is on one side of a plane through z
    filleted_box,  // edges of a box of size a rounded by b
    nurbs_torus,   // torus, as rational splines
    nurbs_ball,
    two_boxes,  // of sizes a, b, c side by side along x, each with its own face where they touch
    annulus,    // a plane face between circles of radii a (inner) and b about the origin, at z = c
    circles,    // these circles alone
    ellipse,    // a plane face within half axes a, b
    spline,     // a plane face within a closed cubic spline around the origin, about radius a
    half_disc,  // a plane face of radius a where y > 0
    nothing,    // a shape without faces
};

/// A file that is removed with the value.
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

/// `unit` as STEP calls it: MM, M, INCH; lengths are millimetres and are converted to it.
void write_model(Kind kind, const std::array<double, 3>& sizes, const File& file, const char* unit = "MM");

}  // namespace cad_tests
