module;
#include <cstddef>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>
export module camber.run:page;
import camber.core;
import camber.io;
import :check;
import :histogram;
import :solution;

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
    std::string title, version;
    std::string numbers;  ///< lines for a terminal
    std::string command;  ///< that the page is of
};

/// The page. Errors: a mesh without elements or faces (input), memory, stopped.
[[nodiscard]] Outcome<std::string> page(const PageSource& source, const PageFrame& frame, const PageOptions& options,
                                        const Execution& execution);

/// What a report.json tells of before and after correction, as lines for a terminal; empty: it has no such.
[[nodiscard]] std::string before_and_after(std::string_view report_json);
/// The mesh that a run wrote, by its report.json; empty: none.
[[nodiscard]] std::string mesh_of_report(std::string_view report_json);

}  // namespace camber::run
