// What is curvature worth to a solver? −Δu = f with a known solution u, Dirichlet data u on the whole boundary, solved
// with isoparametric P2 elements on meshes of degree 2, and on the first one with its nodes in the middles of the
// chords:
//
//     poisson MESH… [--thickness 0.05] [--radius 1] [--solution layer|linear|quadratic] [--points 5]
//
// `layer` is u = exp(−(r − radius)/thickness), r the distance to the origin. The others check the program:
// isoparametric elements hold a linear u exactly, straight ones a quadratic u too. Each mesh is its own domain, u is
// known beyond the wall too, and errors are taken over the mesh: what differs is how well the mesh carries u, not where
// it ends. The H1 error is at most that of the interpolant of `camber check --field`, which has the same boundary
// values.
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

import camber.core;
import camber.bezier;
import camber.interpolation;
import camber.io;

#include "poisson.hpp"

using namespace camber;
using namespace poisson;

namespace {

struct Arguments {
    std::vector<std::string> files;
    std::string solution = "layer";
    double thickness = 0.05, radius = 1;
    int points = 5;
};

template <int D>
KnownSolution<D> layer(double radius, double thickness) {
    const auto u = [=](const Vec<D>& x) { return std::exp(-(norm(x) - radius) / thickness); };
    return {.value = u,
            .gradient = [=](const Vec<D>& x) { return x * (-u(x) / (thickness * norm(x))); },
            .source = [=](const Vec<D>& x) { return u(x) / thickness * ((D - 1) / norm(x) - 1 / thickness); }};
}

template <int D>
KnownSolution<D> linear() {
    return {.value = [](const Vec<D>& x) { return 1 + x[0] - 2 * x[D - 1]; },
            .gradient =
                [](const Vec<D>&) {
                    Vec<D> slope;
                    slope[0] = 1;
                    slope[D - 1] = -2;
                    return slope;
                },
            .source = [](const Vec<D>&) { return 0.0; }};
}

template <int D>
KnownSolution<D> quadratic() {
    return {.value = [](const Vec<D>& x) { return norm_squared(x) + x[0] * x[1]; },
            .gradient =
                [](const Vec<D>& x) {
                    Vec<D> slope = 2 * x;
                    slope[0] += x[1];
                    slope[1] += x[0];
                    return slope;
                },
            .source = [](const Vec<D>&) { return -2.0 * D; }};
}

struct Mesh {
    std::string path;
    std::variant<QuadraticMesh<2>, QuadraticMesh<3>> mesh;
};

Outcome<Mesh> read(const std::string& path) {
    if (std::filesystem::is_directory(path)) return fail(ErrorKind::input, "is a folder", path, {}, "name a file");
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file) return fail(ErrorKind::input, "cannot be read", path, {}, "check the path");
    auto decoded = decode_mesh(std::as_bytes(std::span(bytes)), path, Execution{});
    if (decoded) decoded = with_flat_in_2d(std::move(*decoded), Execution{});
    if (!decoded) return fail(decoded.error());
    return std::visit(
        [&]<class M>(M& mesh) -> Outcome<Mesh> {
            constexpr int D = M::dimension;
            if constexpr (std::is_same_v<M, LinearMesh<D>>) {
                return fail(ErrorKind::input, "the mesh is of degree 1, not 2", path, {},
                            "make it one: camber curve " + path + " -o P2.meshb");
            } else {
                if (mesh.linear.elements.size() == 0)
                    return fail(ErrorKind::input, std::string("has no ") + (D == 3 ? "tetrahedra" : "triangles"), path,
                                {}, "give a mesh of a volume, or of the plane");
                return Mesh{path, std::move(mesh)};
            }
        },
        decoded->mesh);
}

template <int D>
KnownSolution<D> chosen(const Arguments& arguments) {
    if (arguments.solution == "linear") return linear<D>();
    if (arguments.solution == "quadratic") return quadratic<D>();
    return layer<D>(arguments.radius, arguments.thickness);
}

template <int D>
Outcome<Row> row_of(const QuadraticMesh<D>& mesh, const Arguments& arguments) {
    return solve_on(mesh, conical_rule<D>(arguments.points), chosen<D>(arguments));
}

/// The same vertices, with nodes in the middles of the chords.
template <int D>
Outcome<Row> straight_row_of(const QuadraticMesh<D>& mesh, const Arguments& arguments) {
    const auto straight = elevate(mesh.linear, Execution{});
    if (!straight) return fail(straight.error());
    return row_of(*straight, arguments);
}

void print_head(const Arguments& a) {
    if (a.solution == "layer")
        std::printf("u = exp(−(r − %g)/%g)", a.radius, a.thickness);
    else
        std::printf("u %s", a.solution.c_str());
    std::printf(
        "; quadrature: conical Gauss product, %d points a direction; straight: the first mesh's vertices, nodes in "
        "the middles of the chords\n\n"
        "| mesh | unknowns | L2 error | H1 error | L2: straight/this | H1: straight/this | turned elements | solved by "
        "| seconds |\n|---|---|---|---|---|---|---|---|---|\n",
        a.points);
}

void print(const std::string& name, const Row& row, const Row& straight) {
    std::printf("| %s | %d | %.3e | %.3e | %.3g | %.3g | %zu | %s | %.1f |\n", name.c_str(), row.unknowns, row.l2,
                row.h1, straight.l2 / row.l2, straight.h1 / row.h1, row.turned, row.method.c_str(), row.seconds);
    std::fflush(stdout);
}

Outcome<Done> run(const Arguments& arguments) {
    const auto of_file = [](Error error, const std::string& path) {
        if (error.where.empty()) error.where = path;
        return fail(std::move(error));
    };
    std::optional<Row> straight;
    for (const std::string& path : arguments.files) {
        const auto mesh = read(path);
        if (!mesh) return fail(mesh.error());
        if (!straight) {
            const auto row = std::visit([&](const auto& m) { return straight_row_of(m, arguments); }, mesh->mesh);
            if (!row) return of_file(row.error(), path + ", straight");
            straight = *row;
            print_head(arguments);
            print("straight", *straight, *straight);
        }
        const auto row = std::visit([&](const auto& m) { return row_of(m, arguments); }, mesh->mesh);
        if (!row) return of_file(row.error(), path);
        print(path, *row, *straight);
    }
    return Done{};
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
    const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
    return result.ec == std::errc() && result.ptr == text.data() + text.size() && number > 0;
}

bool read_option(std::string_view name, std::string_view value, Arguments& arguments) {
    if (name == "--thickness") return read_number(value, arguments.thickness);
    if (name == "--radius") return read_number(value, arguments.radius);
    if (name == "--points") return read_number(value, arguments.points) && arguments.points <= 20;
    arguments.solution = value;
    return name == "--solution" && (value == "layer" || value == "linear" || value == "quadratic");
}

std::optional<Arguments> read_arguments(std::span<char*> words) {
    Arguments arguments;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string_view word = words[i];
        if (!word.starts_with("--"))
            arguments.files.emplace_back(word);
        else if (++i == words.size() || !read_option(word, words[i], arguments))
            return {};
    }
    if (arguments.files.empty()) return {};
    return arguments;
}

}  // namespace

/// 0 if all was solved, 2 for wrong arguments, 3 for a mesh that cannot be read or solved on.
int main(int count, char** words) {
    const auto arguments = read_arguments(std::span(words, static_cast<std::size_t>(count)).subspan(1));
    if (!arguments) {
        std::fprintf(stderr,
                     "poisson MESH… [--thickness D] [--radius R] [--solution layer|linear|quadratic] [--points 1…20]: "
                     "errors of Poisson's equation, solved on meshes of degree 2; lengths above 0\n");
        return 2;
    }
    const auto done = run(*arguments);
    if (!done) std::fprintf(stderr, "%s\n", describe(done.error()).c_str());
    return done ? 0 : 3;
}
