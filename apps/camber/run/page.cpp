module;
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.bezier;
import camber.io;
import :check;
import :histogram;
import :page;
import :page_arrays;
import :page_parts;
import :plot;
import :rows;
import :solution;

namespace camber::run {

namespace {

std::string escaped(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (const char c : text) switch (c) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out += c;
        }
    return out;
}

std::string tile(std::string_view name, const std::string& value) {
    return fmt::format("<li><b>{}</b><span>{}</span></li>\n", escaped(value), name);
}

std::string tiles(const CheckReport& report) {
    const MeshReport& m = report.mesh;
    const bool of_triangles = m.is_surface_alone() || m.dimension == 2;
    std::string text =
        tile(of_triangles ? "triangles" : "tetrahedra", grouped(m.judged())) + tile("nodes", grouped(m.nodes)) +
        tile("dimension, degree", fmt::format("{}D, P{}", m.dimension, m.degree)) +
        tile("invalid", grouped(report.validity.invalid)) + tile("undecided", grouped(report.validity.undecided));
    if (m.degree == 2) return text + tile("least scaled Jacobian", lower_bound_text(report.validity.smallest));
    return report.worst.empty() ? text : text + tile("least quality", fmt::format("{:.4g}", report.worst[0].quality));
}

/// A button an element.
std::string worst_section(const CheckReport& report) {
    if (report.worst.empty()) return {};
    std::string text = fmt::format("<section>\n<h2>The worst {}</h2>\n<ol class=\"worst\">\n", report.worst.size());
    for (std::size_t i = 0; i < report.worst.size(); ++i) {
        const ElementReport& e = report.worst[i];
        const bool is_curved = report.mesh.degree == 2;
        text += fmt::format(
            "<li><button id=\"worst-{}\" aria-pressed=\"false\"><span>element {}</span><span{}>{} {}</span>"
            "</button></li>\n",
            i, grouped(e.number), e.verdict == Verdict::valid ? "" : " class=\"bad\"",
            is_curved ? "scaled Jacobian" : "quality",
            is_curved ? lower_bound_text(e.min_scaled_jacobian) : fmt::format("{:.4g}", e.quality));
    }
    return text + "</ol>\n</section>\n";
}

std::string histogram_section(const std::vector<Histogram>& histograms) {
    if (histograms.empty()) return {};
    std::string text = "<section>\n<h2>Histograms</h2>\n<div class=\"plots\">\n";
    for (const Histogram& histogram : histograms) text += svg(histogram);
    return text + "</div>\n</section>\n";
}

using Placeholders = std::vector<std::pair<std::string_view, std::string>>;

/// The frame with a text for each of its placeholders.
std::string filled(std::string_view frame, const Placeholders& placeholders) {
    std::size_t size = frame.size();
    for (const auto& [name, text] : placeholders) size += 3 * text.size();
    std::string out;
    out.reserve(size);
    for (std::size_t at = 0; at < frame.size();) {
        const std::size_t open = frame.find("{{", at), close = frame.find("}}", open);
        if (close == std::string_view::npos) {
            out += frame.substr(at);
            break;
        }
        out += frame.substr(at, open - at);
        const std::string_view wanted = frame.substr(open + 2, close - open - 2);
        for (const auto& [name, text] : placeholders)
            if (name == wanted) out += text;
        at = close + 2;
    }
    return out;
}

template <int D>
Outcome<std::string> page_of(const QuadraticMesh<D>& mesh, const PageSource& source, const PageFrame& frame,
                             const PageOptions& options, const Execution& execution) {
    const auto faces = page_mesh(mesh, source.report, options, part_of(execution, 0, 0.6));
    if (!faces) return fail(faces.error());
    PageQuantities values = page_quantities(*faces, source);
    std::vector<PageArray> arrays = arrays_of(*faces);
    for (PageArray& array : values.arrays) arrays.push_back(std::move(array));
    const auto scripts = packed(std::move(arrays), part_of(execution, 0.6, 1));
    if (!scripts) return fail(scripts.error());
    std::string data;
    for (const std::string& script : *scripts) data += script;
    const CheckReport& report = source.report;
    return filled(frame.frame, {{"version", escaped(source.version)},
                                {"title", escaped(source.title)},
                                {"dimension", D == 2 ? "flat" : "solid"},
                                {"style", frame.style},
                                {"script", frame.script},
                                {"verdict", report.all_good() ? "good" : "bad"},
                                {"answer", escaped(check_answer(report))},
                                {"tiles", tiles(report)},
                                {"worst", worst_section(report)},
                                {"histograms", histogram_section(source.histograms)},
                                {"numbers", escaped(source.numbers)},
                                {"command", escaped(source.command)},
                                {"page", page_json(*faces, values.quantities)},
                                {"arrays", data}});
}

template <int D>
Outcome<std::string> page_of(const LinearMesh<D>& mesh, const PageSource& source, const PageFrame& frame,
                             const PageOptions& options, const Execution& execution) {
    const auto elevated = elevate(mesh, part_of(execution, 0, 0.2));
    if (!elevated) return fail(elevated.error());
    return page_of(*elevated, source, frame, options, part_of(execution, 0.2, 1));
}

}  // namespace

Outcome<std::string> page(const PageSource& source, const PageFrame& frame, const PageOptions& options,
                          const Execution& execution) {
    return guarded([&]() -> Outcome<std::string> {
        return std::visit([&](const auto& mesh) { return page_of(mesh, source, frame, options, execution); },
                          source.mesh);
    });
}

}  // namespace camber::run
