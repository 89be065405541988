// Pictures: areas of discs and silhouettes, the same bytes for any number of threads, curves through the nodes.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

import camber.core;
import camber.bezier;
import camber.drawing;

#include "meshes.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

constexpr double pi = std::numbers::pi;

FaceValues ones() {
    return [](const Face&) { return std::array<float, 6>{1, 1, 1, 1, 1, 1}; };
}

template <int D>
Scene scene_of(const QuadraticMesh<D>& mesh, PictureOptions options) {
    const auto faces = must(faces_to_draw(as_mesh(mesh), {}, Execution{}));
    return must(make_scene(as_mesh(mesh), faces.view(), ones(), {}, std::move(options), Execution{}));
}

/// The covered area in model units².
double covered_area(const Scene& scene, const Image& image) {
    double pixels = 0;
    for (std::size_t i = 3; i < image.bytes.size(); i += 4) pixels += image.bytes[i] / 255.0;
    return pixels / (scene.projection.scale * scene.projection.scale);
}

/// A fan of n triangles whose rim has its nodes on the unit circle.
QuadraticMesh<2> disc(std::size_t n) {
    Buffer<Vec<2>> points{Vec<2>{}};
    Buffer<SimplexVertices<2>> triangles;
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * pi * static_cast<double>(i) / static_cast<double>(n);
        points.push_back({{std::cos(angle), std::sin(angle)}});
        triangles.push_back({VertexId(std::size_t{0}), VertexId(i + 1), VertexId((i + 1) % n + 1)});
    }
    auto mesh = must(elevate(mesh_of<2>(std::move(points), std::move(triangles)), Execution{}));
    auto nodes = take(mesh.mid_nodes);
    for (std::size_t e = 0; e < nodes.size(); ++e)
        if (mesh.edges.vertices[e][0].index() != 0) nodes[e].point = normalised(nodes[e].point);
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

/// A cube of tetrahedra mapped to the unit ball; coarse, but round with its nodes on the sphere.
QuadraticMesh<3> ball(int cells, bool is_curved) {
    const auto blown = [](const Vec<3>& p) {
        const double most = std::fmax(std::fmax(std::abs(p[0]), std::abs(p[1])), std::abs(p[2]));
        return norm(p) > 0 ? p * (most / norm(p)) : p;
    };
    LatticeOptions<3> options;
    options.cells = {cells, cells, cells};
    const double half = cells / 2.0;
    options.place = [&](const Vec<3>& p) { return blown((p - Vec<3>{{half, half, half}}) / half); };
    auto mesh = must(elevate(lattice_mesh<3>(options), Execution{}));
    if (!is_curved) return mesh;
    auto nodes = take(mesh.mid_nodes);
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto [a, b] = mesh.edges.vertices[e];
        const double ra = norm(mesh.linear.points[a]), rb = norm(mesh.linear.points[b]);
        if (ra > 1 - 1e-9 && rb > 1 - 1e-9) nodes[e].point = normalised(nodes[e].point);
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

PictureOptions transparent_picture(std::size_t size) {
    PictureOptions options;
    options.width = options.height = size;
    options.background = Background::transparent;
    return options;
}

}  // namespace

TEST_CASE("the picture of a disc has the area of the disc") {
    for (const std::size_t n : {5, 9}) {
        const Scene scene = scene_of(disc(n), transparent_picture(300));
        const double area = covered_area(scene, must(rasterised(scene, Execution{})));
        CHECK(std::abs(area - pi) < 0.01 * pi);
    }
    // With five straight edges the area would be 76 % of that.
    PictureOptions without = transparent_picture(300);
    without.edges = Edges::hidden;
    const Scene scene = scene_of(disc(5), without);
    CHECK(std::abs(covered_area(scene, must(rasterised(scene, Execution{}))) - pi) < 0.01 * pi);
}

TEST_CASE("the silhouette of a coarse curved ball is a circle") {
    const auto curved = ball(4, true), straight = ball(4, false);
    for (const Vec<3>& from : {Vec<3>{{1, 0, 0}}, Vec<3>{{1, -1.6, 0.9}}, Vec<3>{{0, 0, 1}}}) {
        PictureOptions options = transparent_picture(300);
        options.view = view_from(from);
        const Scene scene = scene_of(curved, options), flat = scene_of(straight, options);
        CHECK(std::abs(covered_area(scene, must(rasterised(scene, Execution{}))) - pi) < 0.01 * pi);
        CHECK(covered_area(flat, must(rasterised(flat, Execution{}))) < 0.98 * pi);
    }
}

TEST_CASE("pictures do not depend on the number of threads") {
    PictureOptions options;
    options.width = 320;
    options.height = 200;
    options.view = view_from(Vec<3>{{1, -1.6, 0.9}});
    options.colouring = ColourRange{0, 1, Ramp::good_is_high};
    options.title = "quality";
    const Scene scene = scene_of(ball(3, true), options);
    const auto draw = [&](int threads) {
        const Execution execution{.threads = threads};
        const Image image = with_marks(must(rasterised(scene, execution)), marks_of(scene));
        return std::pair(must(png(image)), must(svg_of(scene, execution)));
    };
    const auto one = draw(1);
    CHECK(one.first == draw(2).first);
    CHECK(one.second == draw(3).second);
}

TEST_CASE("visible faces of a solid point towards the viewer") {
    const auto solid = ball(2, true);
    const Scene scene = scene_of(solid, transparent_picture(200));
    const auto visible = must(visible_faces(scene, Execution{}));
    CHECK(visible.size() < scene.patches.size());
    for (const std::uint32_t f : visible) {
        double most = -1;
        for (const FacePoint& xi : {FacePoint{1, 0, 0}, FacePoint{0, 1, 0}, FacePoint{0, 0, 1}})
            most = std::fmax(most, normal_at(scene.patches[f].nodes, xi)[2]);
        CHECK(most > 0);
    }
}

namespace {

/// End points and midpoints of the quadratic segments of all paths.
std::vector<Vec<2>> points_of_paths(const std::string& svg) {
    std::vector<Vec<2>> points;
    for (std::size_t at = svg.find(" d=\""); at != std::string::npos; at = svg.find(" d=\"", at + 1)) {
        const char* c = svg.c_str() + at + 4;
        Vec<2> last{};
        const auto number = [&] {
            char* end = nullptr;
            const double x = std::strtod(c, &end);
            c = end;
            return x;
        };
        const auto point = [&] {
            const double x = number(), y = number();
            return Vec<2>{{x, y}};
        };
        while (*c != '"' && *c != 'z') {
            const char command = *c++;
            if (command == 'q') {
                const Vec<2> control = last + point(), end = last + point();
                points.push_back(0.25 * last + 0.5 * control + 0.25 * end);
                last = end;
            } else {
                last = last + point();
            }
            points.push_back(last);
        }
    }
    return points;
}

}  // namespace

TEST_CASE("SVG paths pass through the nodes") {
    const auto mesh = disc(7);
    const Scene scene = scene_of(mesh, transparent_picture(400));
    const auto points = points_of_paths(must(svg_of(scene, Execution{})));
    const auto nearest = [&](const Vec<2>& node) {
        const Vec<3> on_paper = scene.projection(in_space(node));
        double best = 1e9;
        for (const Vec<2>& p : points) best = std::fmin(best, std::hypot(p[0] - on_paper[0], p[1] - on_paper[1]));
        return best;
    };
    for (const Vec<2>& vertex : mesh.linear.points) CHECK(nearest(vertex) < 0.1);
    for (std::size_t e = 0; e < mesh.edges.size(); ++e)
        if (mesh.edges.vertices[e][0].index() != 0) CHECK(nearest(mesh.mid_nodes[e].point) < 0.1);
}

TEST_CASE("colours are assigned to ranges, kinds and missing values") {
    const Theme theme = theme_of(Background::light);
    CHECK(hex({1, 0.5, 0}) == "#ff8000");
    const Colouring range = ColourRange{0, 1, Ramp::plain};
    CHECK(colour_of(range, -1, theme) == colour_at(Ramp::plain, 0));
    CHECK(colour_of(range, 2, theme) == colour_at(Ramp::plain, 1));
    CHECK(colour_of(range, std::nan(""), theme) == theme.missing);
    const Colouring kinds = ColourKinds{{1, 4}};
    CHECK(colour_of(kinds, 1, theme) == colour_of_kind(1));
    CHECK(colour_of(kinds, 0.9999, theme) == colour_of_kind(1));
    CHECK(colour_of(kinds, 2, theme) == theme.missing);
    const ColourRange logarithmic{1, 100, Ramp::plain, Spacing::logarithmic};
    CHECK(std::abs(logarithmic.place_of(10) - 0.5) < 1e-12);
    CHECK(std::abs(logarithmic.value_at(0.5) - 10) < 1e-12);
    CHECK(short_number(0.123456) == "0.123");
}

TEST_CASE("pictures are drawn at extreme zoom") {
    for (const double radius : {1e-3, 1e-30}) {
        PictureOptions options = transparent_picture(60);
        options.zoom = PictureOptions::Zoom{{{0.3, 0.2, 0}}, radius};
        const Scene scene = scene_of(disc(5), options);
        const Image image = must(rasterised(scene, Execution{}));
        if (radius > 1e-9) CHECK(image.bytes[4 * (30 * 60 + 30) + 3] == 255);
        CHECK(must(svg_of(scene, Execution{})).ends_with("</svg>\n"));
    }
}

TEST_CASE("drawing an empty scene is an error") {
    const auto mesh = disc(5);
    const auto scene = make_scene<2>(as_mesh(mesh), {}, ones(), {}, {}, Execution{});
    REQUIRE(!scene);
    CHECK(scene.error().kind == ErrorKind::input);
}

TEST_CASE("legend numbers have the precision of the range") {
    PictureOptions options;
    options.colouring = ColourRange{-1.00013, 1.00027};
    std::vector<std::string> texts;
    for (const PictureMark& mark : marks_of(scene_of(disc(5), options)))
        if (const auto* text = std::get_if<TextMark>(&mark)) texts.push_back(text->text);
    CHECK(texts == std::vector<std::string>{"", "-1", "-0.5", "0", "0.5", "1"});
}

TEST_CASE("a zoomed picture covers its box and nothing else") {
    property("the box of a zoomed picture is covered for any size and legend", [](std::uint64_t seed) {
        PictureOptions options = transparent_picture(60);
        options.width = 60 + seed % 97;
        options.height = 60 + seed % 71;
        options.zoom = PictureOptions::Zoom{{{0.1, 0.2, 0}}, 0.05};
        if (seed % 2 == 0) options.colouring = ColourRange{0, 1};
        const Scene scene = scene_of(disc(9), options);
        RC_ASSERT(scene.clip.has_value());
        const PaperFrame& box = *scene.clip;
        RC_ASSERT(box.left >= 0 && box.top >= 0);
        RC_ASSERT(box.left + box.width <=
                  static_cast<double>(options.width) - (options.has_legend() ? legend_width(options) : 0) + 1e-9);
        const Image image = must(rasterised(scene, Execution{}));
        std::size_t outside = 0, gaps = 0;
        for (std::size_t y = 0; y < image.height; ++y)
            for (std::size_t x = 0; x < image.width; ++x) {
                const auto px = static_cast<double>(x), py = static_cast<double>(y);
                const double right = box.left + box.width, bottom = box.top + box.height;
                const std::uint8_t opaque = image.bytes[4 * (y * image.width + x) + 3];
                const bool is_outside = px + 1 <= box.left || px >= right || py + 1 <= box.top || py >= bottom;
                const bool is_inside = px >= box.left && px + 1 <= right && py >= box.top && py + 1 <= bottom;
                outside += is_outside && opaque != 0 ? 1 : 0;
                gaps += is_inside && opaque != 255 ? 1 : 0;
            }
        RC_ASSERT(outside == 0U);
        RC_ASSERT(gaps == 0U);
        RC_ASSERT(must(svg_of(scene, Execution{})).find("clip-path=\"url(#box)\"") != std::string::npos);
    });
}

TEST_CASE("a legend lists the drawn kinds by name") {
    PictureOptions options;
    options.colouring = ColourKinds{{1, 2, 5, 7}, {"inlet", "", "", std::string(100, 'w')}, {1, 1, 0, 1}};
    options.title = "group";
    std::vector<std::string> texts;
    for (const PictureMark& mark : marks_of(scene_of(disc(5), options)))
        if (const auto* text = std::get_if<TextMark>(&mark)) texts.push_back(text->text);
    REQUIRE(texts.size() == 4);
    CHECK(texts[0] == "group");
    CHECK(texts[1] == "inlet (1)");
    CHECK(texts[2] == "2");
    CHECK(texts[3].ends_with("www..."));
    CHECK(texts[3].size() < 60);
}
