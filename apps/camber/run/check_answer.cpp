module;
#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.run;
import camber.core;
import :check;
import :check_parts;
import :file_numbers;
import :report;
import :rows;

namespace camber::run {

namespace {

std::string_view judged_name(const MeshReport& m) { return m.is_surface_alone() ? "triangles" : "elements"; }

/// "42 of 252 elements are …".
std::string share(const CheckReport& report, std::size_t count, std::string_view what) {
    return fmt::format("{} of {} {} {} {}", grouped(count), grouped(report.mesh.judged()), judged_name(report.mesh),
                       count == 1 ? "is" : "are", what);
}

constexpr std::string_view reversed_elements = "reversed_elements";

std::string invalid_text(const CheckReport& report) {
    const ValidityReport& v = report.validity;
    if (report.is_only_reversed)
        return share(report, v.invalid,
                     "numbered the wrong way round, and valid otherwise: commands that curve or change a mesh turn "
                     "such elements, and `camber repair` writes the mesh with them turned");
    if (report.mesh.degree == 1) return share(report, v.invalid, "inverted or flat: mend the straight mesh");
    const bool is_below = v.bound > 0;
    std::string text = share(report, v.invalid,
                             is_below ? fmt::format("below the scaled Jacobian {:g}", v.bound) : "inverted somewhere");
    if (v.straight_inverted >= v.invalid) return text + ", when straight too: mend the straight mesh";
    if (report.mesh.is_surface_alone()) return text + ": smaller triangles bow less";
    return text + "; `camber repair` mends such, with `--cad MODEL` where the boundary alone makes them so";
}

/// What makes the mesh no good one, the gravest first.
std::vector<std::string> faults(const CheckReport& report) {
    std::vector<std::string> all;
    if (report.soundness.empty) return {"the mesh is empty"};
    if (report.validity.invalid > 0) all.push_back(invalid_text(report));
    if (report.validity.undecided > 0)
        all.push_back(share(report, report.validity.undecided, "too near to the bound to be certified"));
    for (const SoundnessReport::Entry& found : report.soundness.findings)
        if (found.count > 0 && found.harms && !(report.is_only_reversed && found.key == reversed_elements))
            all.push_back(found.sentence);
    if (report.crossings.crossing > 0)
        all.push_back(fmt::format("{} pairs of {} of the boundary pass through each other",
                                  grouped(report.crossings.crossing),
                                  report.mesh.dimension == 2 ? "edges" : "triangles"));
    if (report.overlaps.overlapping > 0)
        all.push_back("elements overlap: " + overlap_text(report.overlaps.found.front(), report.mesh));
    return all;
}

}  // namespace

std::string overlap_text(const OverlapReport& overlap, const MeshReport& mesh) {
    const std::string_view elements = mesh.dimension == 2 ? "triangles" : "tetrahedra";
    return fmt::format("{} {} and {} overlap at ({:.6g})", elements, called(overlap.elements[0], overlap.tags[0]),
                       called(overlap.elements[1], overlap.tags[1]), fmt::join(overlap.point, ", "));
}

std::string check_answer(const CheckReport& report) {
    const std::vector<std::string> bad = faults(report);
    if (!bad.empty()) {
        const std::string more =
            bad.size() == 1 ? std::string() : fmt::format(" (and {} more faults, below)", bad.size() - 1);
        return "NO: " + bad.front() + more;
    }
    const std::size_t n = report.mesh.judged();
    std::string text = n == 0 ? std::string("yes: the mesh is sound")
                              : fmt::format("yes: all {} {} are certified valid, and the mesh is sound", grouped(n),
                                            judged_name(report.mesh));
    const CrossingsReport& c = report.crossings;
    if (c.touching + c.undecided > 0)
        text +=
            fmt::format("; {} pairs of its boundary touch, or are too near to tell", grouped(c.touching + c.undecided));
    return text;
}

}  // namespace camber::run
