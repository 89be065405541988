module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>
module camber.run:page_parts;
import camber.core;
import camber.bezier;
import camber.drawing;
import :check;
import :page;
import :page_arrays;
import :page_mesh;
import :solution;

/// From a mesh to the arrays of a page.
namespace camber::run {

/// The worst of the elements: faces first … first + count of those of the worst.
struct PageWorst {
    std::size_t first = 0, count = 0;
    std::array<double, 3> centre{};
    double radius = 0;
    std::vector<double> point = {};  ///< where det J is lowest; empty: not known
};

/// Faces with their nodes and elements, which are numbered anew, by first use.
template <int D>
struct PageMesh {
    const QuadraticMesh<D>* mesh = nullptr;
    int degree = 2;
    Box<D> box = {};     ///< of the vertices
    Vec<D> centre = {};  ///< from which nodes are told
    double radius = 0;   ///< of the nodes around it
    std::vector<Face> outer = {};
    InnerFaces inner = {};
    std::vector<PageWorst> worst = {};
    std::size_t worst_faces = 0;
    std::vector<std::uint32_t> face_nodes = {};  ///< three or six a face: outer, inner, worst
    std::vector<NodeNumber> nodes = {};          ///< the mesh's, of the page's
    std::vector<std::uint32_t> owners = {};      ///< one an outer face, two an inner one, one of those of the worst
    std::vector<std::uint32_t> elements = {};    ///< the mesh's, of the page's
    Column<CutKeys> keys = {};                   ///< of the mesh's
};
template <int D>
[[nodiscard]] Outcome<PageMesh<D>> page_mesh(const QuadraticMesh<D>& mesh, const CheckReport& report,
                                             const PageOptions& options, const Execution& execution);

/// The arrays `faces`, `nodes`, `owners` and `keys`.
template <int D>
[[nodiscard]] std::vector<PageArray> arrays_of(const PageMesh<D>& mesh);

enum class ValuesOn : std::uint8_t { elements, nodes, faces };
enum class ValueScale : std::uint8_t { linear, log, categories };

/// What faces can be coloured by, its values in an array by its key.
struct PageQuantity {
    std::string key, title;
    ValuesOn on = ValuesOn::elements;
    ValueScale scale = ValueScale::linear;
    bool good_is_high = false;
    std::array<double, 2> range{};                                   ///< of the finite values
    std::optional<std::array<double, 2>> whole = {};                 ///< all that it can be, by the usual
    std::optional<double> bad = {};                                  ///< elements with no more are invalid
    std::vector<std::pair<Reference, std::string>> categories = {};  ///< with names, where they have such
};
struct PageQuantities {
    std::vector<PageQuantity> quantities;
    std::vector<PageArray> arrays;
};
template <int D>
[[nodiscard]] PageQuantities page_quantities(const PageMesh<D>& mesh, const PageSource& source);

/// The page's values, which its script reads, as JSON that may stand in HTML.
template <int D>
[[nodiscard]] std::string page_json(const PageMesh<D>& mesh, const std::vector<PageQuantity>& quantities);

}  // namespace camber::run
