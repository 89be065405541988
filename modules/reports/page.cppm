module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>
export module camber.reports:page;
import camber.core;
import camber.recipes;
import camber.drawing;
import camber.bezier;
import camber.io;

/// A mesh and what is known of it as one HTML file, for a browser: `camber report`. What is in it: docs/page.md.
export namespace camber::run {

struct PageOptions {
    std::size_t inner_faces = 400'000;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("inner_faces", &PageOptions::inner_faces,
                                 "how many faces inside of the mesh the page may hold for its cut: all, or those at as "
                                 "many places as have room")
                              .at_least(0)
                              .at_most(1e8));
    }
};

/// The parts that all pages have: the frame with its places, "{{title}}" and so on, the style, and the script.
struct PageFrame {
    std::string frame, style, script;
};

struct PageSource {
    AnyMesh mesh;        ///< which was checked, as it was read
    CheckReport report;  ///< of that mesh
    /// On the mesh: of a vector the length is shown, of a symmetric tensor, a metric, its anisotropy.
    std::vector<NamedField> fields = {};
    std::vector<Histogram> histograms = {};
    std::optional<DistancesReport> distances = {};  ///< from the geometry, by face and edge; none: not known
    std::string title, version;
    std::string numbers;  ///< lines for a terminal
    std::string command;  ///< that the page is of
};

/// The page. Errors: a mesh without elements or faces (input), memory, stopped.
[[nodiscard]] Outcome<std::string> page(const PageSource& source, const PageFrame& frame, const PageOptions& options,
                                        const Execution& execution);

/// Figures of a report.json before and after correction, as lines for a terminal; empty: it has none.
[[nodiscard]] std::string before_and_after(std::string_view report_json);
/// The distances from the geometry in a report.json; none: the run did not measure them by entity.
[[nodiscard]] std::optional<DistancesReport> distances_of_report(std::string_view report_json);
/// The mesh that a run wrote, by its report.json; empty: none.
[[nodiscard]] std::string mesh_of_report(std::string_view report_json);

}  // namespace camber::run

/// Arrays of a page as text: the bytes of words of 32 bits, those of one significance side by side (the lowest first),
/// as a zlib stream, in base64. docs/page.md tells it to others.
namespace camber::run {

/// An array before it is packed.
struct PageArray {
    std::string name;
    std::vector<std::uint8_t> bytes;
};

[[nodiscard]] PageArray array_of_integers(std::string name, std::span<const std::int32_t> integers);
/// To 15 bits of its mantissa.
[[nodiscard]] float rounded_float(float x);
/// Each float to 15 bits of its mantissa: to 1.6e-5 of itself.
[[nodiscard]] PageArray array_of_rounded(std::string name, std::span<const float> numbers);
[[nodiscard]] PageArray array_of_floats(std::string name, std::span<const float> numbers);

/// Ids that count up by first use, each as how far it is below the next new one: mostly small numbers.
[[nodiscard]] PageArray array_of_ids(std::string name, std::span<const std::uint32_t> ids);

/// One a script element, <script id="camber-NAME">; in parallel. Errors: memory, stopped.
[[nodiscard]] Outcome<std::vector<std::string>> packed(std::vector<PageArray> arrays, const Execution& execution);

}  // namespace camber::run

/// Faces of a mesh in a page.
namespace camber::run {

/// Places of a cut along an axis: after step s, the mesh's box being cut into `cut_steps` + 1 equal slices. An element
/// is kept where its key, the step before which its centroid lies, is no later.
inline constexpr int cut_steps = 255;

/// An inner face is seen where the cut keeps one of its elements.
struct InnerFace {
    std::array<NodeNumber, 6> nodes{};
    std::uint32_t element = 0, other = 0;
};

/// Keys of an element along each axis; 0 along axes that the mesh does not have.
using CutKeys = std::array<std::uint8_t, 3>;

/// Inner faces of tetrahedra, and the steps at which all that a cut uncovers are among them.
struct InnerFaces {
    std::vector<InnerFace> faces;
    std::array<std::vector<int>, 3> steps;  ///< along each axis, rising
    std::size_t all = 0;                    ///< that the mesh has
};

}  // namespace camber::run

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
    const Mesh<D>* mesh = nullptr;
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
[[nodiscard]] Outcome<PageMesh<D>> page_mesh(const Mesh<D>& mesh, const CheckReport& report, const PageOptions& options,
                                             const Execution& execution);

/// The arrays `faces`, `nodes`, `owners` and `keys`.
template <int D>
[[nodiscard]] std::vector<PageArray> arrays_of(const PageMesh<D>& mesh);

enum class ValuesOn : std::uint8_t { elements, nodes, faces };
enum class ValueScale : std::uint8_t { linear, log, categories };

/// A quantity that colours faces; its values are in the array with its key.
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

}  // namespace camber::run
