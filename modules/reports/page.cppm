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

/// The page of `camber report`: a mesh and its check as one HTML file. Format: docs/page.md.
export namespace camber::run {

struct PageOptions {
    std::size_t inner_faces = 400'000;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("inner_faces", &PageOptions::inner_faces,
                                 "largest number of inner faces in the page for its cut: all faces, or those at as "
                                 "many cut positions as fit")
                              .at_least(0)
                              .at_most(1e8));
    }
};

/// Common parts of all pages: the frame with placeholders like "{{title}}", the style, and the script.
struct PageFrame {
    std::string frame, style, script;
};

struct PageSource {
    AnyMesh mesh;  ///< the checked mesh, in the file's order
    CheckReport report;
    /// Fields on the mesh. Vectors are shown by their length, symmetric tensors by their anisotropy as metrics.
    std::vector<NamedField> fields = {};
    std::vector<Histogram> histograms = {};
    std::optional<DistancesReport> distances = {};  ///< distances of the faces and edges from the geometry; none:
                                                    ///< unknown
    std::string title, version;
    std::string numbers;  ///< lines for a terminal
    std::string command;  ///< command that the page documents
};

/// Errors: input (a mesh without elements and faces), memory, stopped.
[[nodiscard]] Outcome<std::string> page(const PageSource& source, const PageFrame& frame, const PageOptions& options,
                                        const Execution& execution);

/// Lines for a terminal with numbers before and after correction; empty: the report has none.
[[nodiscard]] std::string before_and_after(std::string_view report_json);
/// Distances from the geometry in a report.json; none: the run did not measure them by entity.
[[nodiscard]] std::optional<DistancesReport> distances_of_report(std::string_view report_json);
/// Mesh that the run of a report.json wrote; empty: none.
[[nodiscard]] std::string mesh_of_report(std::string_view report_json);

}  // namespace camber::run

/// Arrays of a page as text. Bytes of 32-bit words are grouped by significance (lowest first), compressed with zlib,
/// and encoded as base64. Format: docs/page.md.
namespace camber::run {

struct PageArray {
    std::string name;
    std::vector<std::uint8_t> bytes;
};

[[nodiscard]] PageArray array_of_integers(std::string name, std::span<const std::int32_t> integers);
/// Rounds the mantissa to 15 bits.
[[nodiscard]] float rounded_float(float x);
/// Rounds each mantissa to 15 bits: a relative error of 1.6e-5.
[[nodiscard]] PageArray array_of_rounded(std::string name, std::span<const float> numbers);
[[nodiscard]] PageArray array_of_floats(std::string name, std::span<const float> numbers);

/// Encodes ids that are numbered by first use. An id becomes its distance below the next new id, which is usually small
/// and compresses well.
[[nodiscard]] PageArray array_of_ids(std::string name, std::span<const std::uint32_t> ids);

/// Returns one element <script id="camber-NAME"> per array. Runs in parallel. Errors: memory, stopped.
[[nodiscard]] Outcome<std::vector<std::string>> packed(std::vector<PageArray> arrays, const Execution& execution);

}  // namespace camber::run

/// Faces of a mesh in a page.
namespace camber::run {

/// Number of cut positions along an axis. They divide the mesh's bounding box into `cut_steps` + 1 equal slices. A cut
/// at step s keeps elements with a key of at most s. The key is the slice of the element's centroid.
inline constexpr int cut_steps = 255;

/// An inner face is visible if the cut keeps one of its two elements.
struct InnerFace {
    std::array<NodeNumber, 6> nodes{};
    std::uint32_t element = 0, other = 0;
};

/// Keys of an element for each axis; 0 for a missing axis.
using CutKeys = std::array<std::uint8_t, 3>;

/// Inner faces of tetrahedra. Cuts at the listed steps only uncover faces of this list.
struct InnerFaces {
    std::vector<InnerFace> faces;
    std::array<std::vector<int>, 3> steps;  ///< for each axis, ascending
    std::size_t all = 0;                    ///< number of inner faces of the mesh
};

}  // namespace camber::run

/// Converts a mesh to the arrays of a page.
namespace camber::run {

/// One of the worst elements. Its faces are [first, first + count) of all worst elements' faces.
struct PageWorst {
    std::size_t first = 0, count = 0;
    std::array<double, 3> centre{};
    double radius = 0;
    std::vector<double> point = {};  ///< position of the minimum of det J, relative to `PageMesh::centre`; empty:
                                     ///< unknown
};

/// Faces with their nodes and elements, renumbered by first use.
template <int D>
struct PageMesh {
    const Mesh<D>* mesh = nullptr;
    int degree = 2;
    Box<D> box = {};     ///< bounding box of the vertices
    Vec<D> centre = {};  ///< node positions are relative to this point
    double radius = 0;   ///< radius of a ball around `centre` that contains the nodes
    std::vector<Face> outer = {};
    InnerFaces inner = {};
    std::vector<PageWorst> worst = {};
    std::size_t worst_faces = 0;
    std::vector<std::uint32_t> face_nodes = {};  ///< three or six nodes per face: first of outer, then of inner, then
                                                 ///< of worst faces
    std::vector<NodeNumber> nodes = {};          ///< mesh numbers of page nodes
    std::vector<std::uint32_t> owners = {};  ///< elements at the faces: one per outer or worst face, two per inner face
    std::vector<std::uint32_t> elements = {};  ///< mesh numbers of page elements
    Column<CutKeys> keys = {};                 ///< cut keys of the mesh elements
};
template <int D>
[[nodiscard]] Outcome<PageMesh<D>> page_mesh(const Mesh<D>& mesh, const CheckReport& report, const PageOptions& options,
                                             const Execution& execution);

/// Returns the arrays `faces`, `nodes`, `owners` and `keys`.
template <int D>
[[nodiscard]] std::vector<PageArray> arrays_of(const PageMesh<D>& mesh);

enum class ValuesOn : std::uint8_t { elements, nodes, faces };
enum class ValueScale : std::uint8_t { linear, log, categories };

/// A quantity that colours faces. The array named by its key has the values.
struct PageQuantity {
    std::string key, title;
    ValuesOn on = ValuesOn::elements;
    ValueScale scale = ValueScale::linear;
    bool good_is_high = false;
    std::array<double, 2> range{};                                   ///< minimum and maximum of the finite values
    std::optional<std::array<double, 2>> whole = {};                 ///< colour range that is the same for all meshes
    std::optional<double> bad = {};                                  ///< elements with at most this value are invalid
    std::vector<std::pair<Reference, std::string>> categories = {};  ///< references with names, if any
};
struct PageQuantities {
    std::vector<PageQuantity> quantities;
    std::vector<PageArray> arrays;
};
template <int D>
[[nodiscard]] PageQuantities page_quantities(const PageMesh<D>& mesh, const PageSource& source);

}  // namespace camber::run
