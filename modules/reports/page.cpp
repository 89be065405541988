// Pages of reports
module;
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <zlib.h>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.bezier;
import camber.validity;
import camber.io;
import :json;

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
    const bool of_triangles = m.is_standalone_surface() || m.dimension == 2;
    std::string text = tile(of_triangles ? "triangles" : "tetrahedra", grouped(m.judged())) +
                       tile("nodes", grouped(m.nodes)) +
                       tile("dimension, degree", fmt::format("{}D, P{}", m.dimension, m.degree)) +
                       tile("invalid", grouped(report.invalid)) + tile("undecided", grouped(report.undecided));
    if (m.degree == 2) return text + tile("smallest scaled Jacobian", lower_bound_text(report.smallest));
    return report.worst.empty() ? text
                                : text + tile("smallest quality", fmt::format("{:.4g}", *report.worst[0].quality));
}

std::string worst_section(const CheckReport& report) {
    if (report.worst.empty()) return {};
    std::string text = fmt::format("<section>\n<h2>The worst {}</h2>\n<ol class=\"worst\">\n", report.worst.size());
    for (std::size_t i = 0; i < report.worst.size(); ++i) {
        const ElementReport& e = report.worst[i];
        text += fmt::format(
            "<li><button id=\"worst-{}\" aria-pressed=\"false\"><span>element {}</span><span{}>{} {}</span>"
            "</button></li>\n",
            i, grouped(e.number), e.verdict == Verdict::valid ? "" : " class=\"bad\"",
            e.quality ? "quality" : "scaled Jacobian",
            e.quality ? fmt::format("{:.4g}", *e.quality) : lower_bound_text(*e.min_scaled_jacobian));
    }
    return text + "</ol>\n</section>\n";
}

std::string histogram_section(const std::vector<Histogram>& histograms) {
    if (histograms.empty()) return {};
    std::string text = "<section>\n<h2>Histograms</h2>\n<div class=\"plots\">\n";
    for (const Histogram& histogram : histograms) text += svg(histogram);
    return text + "</div>\n</section>\n";
}

std::string distance_cells(const OneWayReport& way) {
    if (way.samples == 0) return "<td>-</td><td>-</td>";
    return fmt::format("<td>{:.4g}</td><td>{:.4g}</td>", way.largest, way.mean);
}

std::string distance_section(const std::optional<DistancesReport>& distances) {
    constexpr std::size_t most = 100;
    if (!distances || distances->entities.empty()) return {};
    std::string text =
        "<section>\n<h2>Distances by face and edge</h2>\n<div class=\"scroll\"><table>\n"
        "<thead><tr><th rowspan=\"2\">farthest first</th><th colspan=\"2\">mesh to geometry</th><th "
        "colspan=\"2\">geometry to mesh</th></tr>\n"
        "<tr><th>largest</th><th>mean</th><th>largest</th><th>mean</th></tr></thead>\n<tbody>\n";
    const std::vector<const EntityReport*> order = farthest_first(*distances);
    for (std::size_t i = 0; i < std::min(most, order.size()); ++i)
        text += fmt::format("<tr><th>{}</th>{}{}</tr>\n", escaped(order[i]->name),
                            distance_cells(order[i]->to_geometry), distance_cells(order[i]->to_boundary));
    text += "</tbody></table></div>\n";
    if (order.size() > most) text += fmt::format("<p class=\"note\">and {} more</p>\n", order.size() - most);
    return text + "</section>\n";
}

using Placeholders = std::vector<std::pair<std::string_view, std::string>>;

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
        const std::string_view placeholder = frame.substr(open + 2, close - open - 2);
        for (const auto& [name, text] : placeholders)
            if (name == placeholder) out += text;
        at = close + 2;
    }
    return out;
}

constexpr int page_format = 1;

std::string_view word(ValuesOn on) {
    return on == ValuesOn::elements ? "elements" : on == ValuesOn::nodes ? "nodes" : "faces";
}
std::string_view word(ValueScale scale) {
    return scale == ValueScale::linear ? "linear" : scale == ValueScale::log ? "log" : "categories";
}

Json json_of(const PageQuantity& q) {
    Json json{{"key", q.key}, {"title", q.title}, {"on", word(q.on)}, {"scale", word(q.scale)}};
    if (q.scale == ValueScale::categories) {
        json["categories"] = Json::array();
        json["names"] = Json::array();
        for (const auto& [reference, name] : q.categories) {
            json["categories"].push_back(reference);
            json["names"].push_back(name);
        }
        return json;
    }
    json["palette"] = q.good_is_high ? "good" : "sequence";
    json["range"] = q.range;
    if (q.whole) json["whole"] = *q.whole;
    if (q.bad) json["bad"] = *q.bad;
    return json;
}

template <int D>
std::vector<double> three(const Vec<D>& v) {
    std::vector<double> out(3, 0.0);
    for (int i = 0; i < D; ++i) out[static_cast<std::size_t>(i)] = v[i];
    return out;
}

std::string note_of_cut(const InnerFaces& inner) {
    if (inner.faces.size() == inner.all)
        return "Whole elements are cut: those with a centroid beyond the plane are "
               "omitted.";
    return fmt::format(
        "Whole elements are cut, at {}, {} and {} positions along x, y and z. The page contains {} of the {} inner "
        "faces (--inner-faces).",
        inner.steps[0].size(), inner.steps[1].size(), inner.steps[2].size(), grouped(inner.faces.size()),
        grouped(inner.all));
}

template <int D>
Json json_of_cut(const PageMesh<D>& page) {
    return {{"steps", cut_steps},
            {"low", three(page.box.low)},
            {"high", three(page.box.high)},
            {"places", page.inner.steps},
            {"note", note_of_cut(page.inner)}};
}

/// Values for the page's script, as JSON that is safe inside HTML.
template <int D>
std::string page_json(const PageMesh<D>& page, const std::vector<PageQuantity>& quantities) {
    Json worst = Json::array(), list = Json::array();
    for (const PageWorst& w : page.worst) {
        worst.push_back({{"first", w.first}, {"count", w.count}, {"centre", w.centre}, {"radius", w.radius}});
        if (!w.point.empty()) worst.back()["point"] = w.point;
    }
    for (const PageQuantity& q : quantities) list.push_back(json_of(q));
    const Json json{{"format", page_format},
                    {"dimension", D},
                    {"degree", page.degree},
                    {"origin", three(page.centre)},
                    {"radius", page.radius},
                    {"counts",
                     {{"faces", page.outer.size()},
                      {"inner", page.inner.faces.size()},
                      {"worst", page.worst_faces},
                      {"nodes", page.nodes.size()},
                      {"elements", page.elements.size()}}},
                    {"quantities", list},
                    {"cut", json_of_cut(page)},
                    {"worst", worst}};
    const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string safe;
    for (const char c : text)
        if (c == '<')
            safe += "\\u003c";  // so that no text can end the script element
        else
            safe += c;
    return safe;
}

template <int D>
Outcome<std::string> page_of(const Mesh<D>& mesh, const PageSource& source, const PageFrame& frame,
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
                                {"answer", escaped(report.answer())},
                                {"tiles", tiles(report)},
                                {"worst", worst_section(report)},
                                {"distances", distance_section(source.distances)},
                                {"histograms", histogram_section(source.histograms)},
                                {"numbers", escaped(source.numbers)},
                                {"command", escaped(source.command)},
                                {"page", page_json(*faces, values.quantities)},
                                {"arrays", data}});
}

}  // namespace

Outcome<std::string> page(const PageSource& source, const PageFrame& frame, const PageOptions& options,
                          const Execution& execution) {
    return guarded([&]() -> Outcome<std::string> {
        return std::visit(
            [&]<int D>(const Mesh<D>&) {
                return of_degree_2<D>(source.mesh, part_of(execution, 0, 0.2)).and_then([&](const auto& mesh) {
                    return page_of(as_mesh(mesh), source, frame, options, part_of(execution, 0.2, 1));
                });
            },
            source.mesh);
    });
}

namespace {

std::vector<std::uint8_t> zipped(const std::vector<std::uint8_t>& bytes) {
    constexpr int level = 6;
    uLongf size = compressBound(bytes.size());
    std::vector<std::uint8_t> out(size);
    if (compress2(out.data(), &size, bytes.data(), bytes.size(), level) != Z_OK) throw std::bad_alloc();
    out.resize(size);
    return out;
}

void append_base64(std::string& text, const std::vector<std::uint8_t>& bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t here = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < here ? bytes[i + k] : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += k <= here ? digits[word >> (18 - 6 * k) & 63U] : '=';
    }
}

std::uint32_t rounded(float x) {
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const bool is_finite = (bits & 0x7f800000U) != 0x7f800000U;
    return is_finite ? (bits + 0x80U) & ~0xffU : bits;
}

/// Groups the bytes of the words by significance, lowest first.
PageArray array_of_words(std::string name, std::span<const std::uint32_t> words) {
    std::vector<std::uint8_t> bytes(4 * words.size());
    for (std::size_t plane = 0; plane < 4; ++plane)
        for (std::size_t i = 0; i < words.size(); ++i)
            bytes[plane * words.size() + i] = static_cast<std::uint8_t>(words[i] >> (8 * plane));
    return {std::move(name), std::move(bytes)};
}

template <class T, class Word>
PageArray converted(std::string name, std::span<const T> items, Word&& word) {
    std::vector<std::uint32_t> words(items.size());
    std::ranges::transform(items, words.begin(), word);
    return array_of_words(std::move(name), words);
}

}  // namespace

float rounded_float(float x) { return std::bit_cast<float>(rounded(x)); }

PageArray array_of_integers(std::string name, std::span<const std::int32_t> integers) {
    return converted(std::move(name), integers, [](std::int32_t i) { return std::bit_cast<std::uint32_t>(i); });
}
PageArray array_of_rounded(std::string name, std::span<const float> numbers) {
    return converted(std::move(name), numbers, rounded);
}
PageArray array_of_floats(std::string name, std::span<const float> numbers) {
    return converted(std::move(name), numbers, [](float x) { return std::bit_cast<std::uint32_t>(x); });
}

PageArray array_of_ids(std::string name, std::span<const std::uint32_t> ids) {
    std::uint32_t next = 0;
    return converted(std::move(name), ids, [&](std::uint32_t id) {
        const std::uint32_t below = next - id;
        if (below == 0) ++next;
        return below;
    });
}

Outcome<std::vector<std::string>> packed(std::vector<PageArray> arrays, const Execution& execution) {
    std::vector<std::string> scripts(arrays.size());
    auto done = each(
        execution, arrays.size(),
        [&](std::size_t i) {
            const std::vector<std::uint8_t> bytes = zipped(arrays[i].bytes);
            arrays[i].bytes = {};
            std::string& text = scripts[i];
            text.reserve(bytes.size() / 3 * 4 + 200);
            text += "<script type=\"application/octet-stream\" id=\"camber-" + arrays[i].name + "\">";
            append_base64(text, bytes);
            text += "</script>\n";
        },
        1);
    if (!done) return fail(done.error());
    return scripts;
}

namespace {

/// Sorted objects find keys fast, even in files with many keys.
using SortedJson = nlohmann::json;

SortedJson value_at(const SortedJson& report, const char* path) {
    const SortedJson::json_pointer pointer(path);
    return report.is_object() && report.contains(pointer) ? report[pointer] : SortedJson();
}

std::string text_of(const SortedJson& number) {
    return number.is_number_integer() ? grouped(number.get<std::size_t>())
                                      : fmt::format("{:.4g}", number.get<double>());
}

}  // namespace

std::string before_and_after(std::string_view report_json) {
    const SortedJson report = SortedJson::parse(report_json, nullptr, false);
    const auto row = [&](std::string_view name, const char* before, const char* after) {
        const SortedJson first = value_at(report, before), last = value_at(report, after);
        if (!first.is_number() || !last.is_number()) return std::string();
        return table_row(name, text_of(first) + " -> " + text_of(last));
    };
    return row("invalid elements", "/validity_before_correction/invalid", "/validity/invalid") +
           row("undecided elements", "/validity_before_correction/undecided", "/validity/undecided") +
           row("smallest scaled Jacobian", "/validity_before_correction/min_scaled_jacobian",
               "/validity/min_scaled_jacobian") +
           row("largest distance to the geometry", "/boundary/largest_distance_straight",
               "/boundary/largest_distance") +
           row("mean length reduction", "/curve/before_correction/mean_length_reduction",
               "/curve/after_correction/mean_length_reduction") +
           row("mean curvature", "/curve/before_correction/mean_curvature", "/curve/after_correction/mean_curvature");
}

std::optional<DistancesReport> distances_of_report(std::string_view report_json) {
    const SortedJson found = value_at(SortedJson::parse(report_json, nullptr, false), "/boundary/distances");
    if (!found.is_object()) return {};
    DistancesReport report;
    try {
        read_json(found, report);
    } catch (const SortedJson::exception&) {
        return {};
    }
    for (EntityReport& entity : report.entities) entity.name = name_of(entity);
    return report;
}

std::string mesh_of_report(std::string_view report_json) {
    const SortedJson found = value_at(SortedJson::parse(report_json, nullptr, false), "/config/output/mesh");
    return found.is_string() ? found.get<std::string>() : std::string();
}

}  // namespace camber::run
