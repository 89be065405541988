module;
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import :page;
import :page_mesh;
import :page_parts;
import :rows;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

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

/// What a cut shows, and what it does not.
std::string note_of_cut(const InnerFaces& inner) {
    if (inner.faces.size() == inner.all) return "By whole elements: those whose centroid lies beyond are left out.";
    return fmt::format(
        "By whole elements, at {}, {} and {} places along x, y and z: {} of the {} faces inside of the mesh are in the "
        "page (--inner-faces).",
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

}  // namespace

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
            safe += "\\u003c";  // no end of the element
        else
            safe += c;
    return safe;
}

template std::string page_json<2>(const PageMesh<2>&, const std::vector<PageQuantity>&);
template std::string page_json<3>(const PageMesh<3>&, const std::vector<PageQuantity>&);

}  // namespace camber::run
