module;
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>
module camber.io:stl_file;
import camber.core;
import :legal_names;
import :listing;
import :stl;

/// What an STL file holds, for its readers and writers.
namespace camber::stl {

/// A binary file: a header, the number of triangles in 4 bytes, and rows of a normal, three corners and an attribute.
inline constexpr std::size_t header_bytes = 80, count_bytes = 4, row_bytes = 50;

struct Triangle {
    std::array<Vec<3>, 3> corners;
    Reference reference = 1;
};
[[nodiscard]] inline bool has_equal_corners(const Triangle& t) {
    return t.corners[0] == t.corners[1] || t.corners[1] == t.corners[2] || t.corners[2] == t.corners[0];
}
using Triangles = Buffer<Triangle>;

/// References of solids: of the same name the same, else the next; a solid without a name has one of its own.
class Solids {
  public:
    [[nodiscard]] Reference of(const std::string& name) {
        if (name.empty()) return ++last_;
        const auto [place, is_new] = known_.try_emplace(name, last_ + 1);
        if (is_new) groups_.push_back({2, ++last_, name});
        return place->second;
    }
    [[nodiscard]] Buffer<Group> groups() && { return std::move(groups_); }

  private:
    Reference last_ = 0;
    std::map<std::string, Reference> known_;
    Buffer<Group> groups_;
};

/// What is written of a mesh, as it is read again but for the vertices.
struct Written {
    Triangles triangles = {};            ///< solid by solid; none has equal corners
    Buffer<Group> groups = {};           ///< the solids, of a text
    std::vector<Renaming> renamed = {};  ///< names of groups and of their solids
    std::size_t left_out = 0;            ///< triangles with equal corners
    std::size_t rounded = 0;  ///< coordinates that 32 bits do not hold, in binary: infinite where they are too large
};
template <class Mesh>
[[nodiscard]] Written written(const Mesh& mesh, const Column<Group>& groups, StlEncoding encoding);

/// The surface: corners at the very same place (−0 is 0) are one vertex. No triangle has equal corners.
[[nodiscard]] listing::Mesh<3> welded(const Triangles& triangles);

}  // namespace camber::stl
