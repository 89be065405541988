// Measures the benefit of curved meshes for a solver. Solves −Δu = f for a known solution u with Dirichlet data u on
// the whole boundary, by isoparametric P2 elements on meshes of degree 2, or of degree 1 with nodes at the midpoints of
// the chords:
//
//     poisson MESH… --field EXPRESSION… [--boundary EXPRESSION] [--solution OUT.sol] [--json] [--threads N]
//     poisson MESH… --thickness 0.05 [--radius 1]
//
// A field is an expression as in `camber check --field`. `--thickness D` is u = exp(−(r − radius)/D), with the distance
// r to the origin.
// Each mesh is its own domain: u is known beyond the wall, and errors are integrated over the mesh. So the errors
// measure the approximation of u, not the position of the boundary.
// `--boundary` gives the boundary data that a solver has: the values on the true walls, such as 0. They are used at
// boundary nodes that are off the walls.
// The errors of the interpolant are printed for comparison. It has the same boundary values, so the H1 error of the
// solution is at most as large.
// Two fields check the program: a linear field is exact on any mesh, a quadratic one on straight elements.
//
// `--solution` writes the solutions of the last mesh at all of its nodes, one field each, in the node order of its
// file. For a mesh of degree 1 the order is that of `camber convert MESH --elevate -o P2.meshb`. `camber metric
// P2.meshb --solution OUT.sol` reads them with that mesh, and so does `camber curve P2.meshb --solution OUT.sol --set
// 'stages=["curve","validate","relax","commit"]'`, which does not move boundary nodes.
#include <charconv>
#include <cstddef>
#include <cstdio>
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
import camber.fields;
import camber.interpolation;
import camber.io;

#include "poisson.hpp"
#include "poisson_files.hpp"

using namespace camber;
using namespace poisson;

namespace {

struct Arguments {
    std::vector<std::string> files, fields;
    double thickness = 0, radius = 1;
    std::string boundary;  ///< empty: the values of each field
    std::string solution;
    bool json = false;
    int threads = 0;
};

/// Printed results of one mesh and field.
struct RowReport {
    std::string mesh, field;
    Row row;
};

/// Returns the fields and the layer of `--thickness`.
std::vector<std::string> fields_of(const Arguments& arguments, int dimension) {
    auto fields = arguments.fields;
    if (arguments.thickness > 0) {
        char text[128];
        std::snprintf(text, sizeof text, "exp(-(sqrt(%s)-%.15g)/%.15g)", dimension == 2 ? "x^2+y^2" : "x^2+y^2+z^2",
                      arguments.radius, arguments.thickness);
        fields.insert(fields.begin(), text);
    }
    return fields;
}

template <int D>
Outcome<std::vector<RowReport>> rows_of(const std::string& path, QuadraticMesh<D> mesh, const Arguments& arguments) {
    const Execution execution{.threads = arguments.threads};
    const auto domain = assemble(std::move(mesh), execution);
    if (!domain) return fail(domain.error());
    std::vector<RowReport> rows;
    for (const std::string& field : fields_of(arguments, D)) {
        const auto expression = ScalarExpression<D>::parsed(field);
        if (!expression) return fail(expression.error());
        const auto on_boundary = ScalarExpression<D>::parsed(arguments.boundary.empty() ? field : arguments.boundary);
        if (!on_boundary) return fail(on_boundary.error());
        auto row = solve_on(*domain, *expression, *on_boundary, execution);
        if (!row) return fail(row.error());
        rows.push_back({path, field, std::move(*row)});
    }
    return rows;
}

Outcome<std::vector<RowReport>> rows_of_file(const std::string& path, const Arguments& arguments) {
    const auto file = read(path);
    if (!file) return fail(file.error());
    auto rows = std::visit([&](const auto& mesh) { return rows_of(path, mesh, arguments); }, file->mesh);
    if (!rows && rows.error().where.empty()) rows.error().where = path;
    if (!rows || arguments.solution.empty() || path != arguments.files.back()) return rows;
    std::vector<Vector> fields;
    for (const RowReport& report : *rows) fields.push_back(report.row.nodal);
    const auto written = write_solution(arguments.solution, *file, fields);
    if (!written) return fail(written.error());
    return rows;
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char letter : text) {
        if (letter == '"' || letter == '\\') out += '\\';
        out += letter;
    }
    return out + '"';
}

void print_json(const std::vector<RowReport>& all) {
    std::printf("[");
    for (const char* between = ""; const auto& [mesh, field, row] : all) {
        std::printf(
            "%s\n {\"mesh\": %s, \"field\": %s, \"unknowns\": %d, \"l2\": %.10g, \"h1\": %.10g, "
            "\"interpolated\": {\"l2\": %.10g, \"h1\": %.10g}, \"turned\": %zu, \"solved_by\": %s, "
            "\"seconds\": %.3f}",
            between, quoted(mesh).c_str(), quoted(field).c_str(), row.unknowns, row.l2, row.h1, row.interpolated_l2,
            row.interpolated_h1, row.inverted, quoted(row.method).c_str(), row.seconds);
        between = ",";
    }
    std::printf("\n]\n");
}

void print_head() {
    std::printf(
        "| mesh | field | unknowns | L2 error | H1 error | L2: first mesh/this | H1: first mesh/this | "
        "interpolant: L2, H1 | turned elements | solved by | seconds |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|\n");
}

void print(const RowReport& report, const Row& first) {
    const Row& row = report.row;
    std::printf("| %s | `%s` | %d | %.3e | %.3e | %.3g | %.3g | %.3e, %.3e | %zu | %s | %.1f |\n", report.mesh.c_str(),
                report.field.c_str(), row.unknowns, row.l2, row.h1, first.l2 / row.l2, first.h1 / row.h1,
                row.interpolated_l2, row.interpolated_h1, row.inverted, row.method.c_str(), row.seconds);
    std::fflush(stdout);
}

Outcome<Done> run(const Arguments& arguments) {
    std::vector<RowReport> all;
    std::size_t fields = 0;
    if (!arguments.json) print_head();
    for (const std::string& path : arguments.files) {
        auto rows = rows_of_file(path, arguments);
        if (!rows) return fail(rows.error());
        fields = rows->size();
        for (RowReport& report : *rows) {
            all.push_back(std::move(report));
            if (!arguments.json) print(all.back(), all[(all.size() - 1) % fields].row);
        }
    }
    if (arguments.json) print_json(all);
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
    if (name == "--threads") return read_number(value, arguments.threads);
    if (name == "--field") arguments.fields.emplace_back(value);
    if (name == "--boundary") arguments.boundary = value;
    if (name == "--solution") arguments.solution = value;
    return name == "--field" || name == "--boundary" || name == "--solution";
}

std::optional<Arguments> read_arguments(std::span<char*> words) {
    Arguments arguments;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string_view word = words[i];
        if (!word.starts_with("--"))
            arguments.files.emplace_back(word);
        else if (word == "--json")
            arguments.json = true;
        else if (++i == words.size() || !read_option(word, words[i], arguments))
            return {};
    }
    if (arguments.files.empty() || fields_of(arguments, 3).empty()) return {};
    return arguments;
}

}  // namespace

/// Exit code: 0 if all problems were solved, 2 for wrong arguments, 3 for a mesh that cannot be read or solved on.
int main(int count, char** words) {
    const auto arguments = read_arguments(std::span(words, static_cast<std::size_t>(count)).subspan(1));
    if (!arguments) {
        std::fprintf(stderr,
                     "poisson MESH… --field EXPRESSION… | --thickness D [--radius R] [--boundary EXPRESSION] "
                     "[--solution OUT.sol] [--json] [--threads N]: errors of Poisson's equation, solved on meshes of "
                     "degree 2; numbers above 0\n");
        return 2;
    }
    const auto done = run(*arguments);
    if (!done) std::fprintf(stderr, "%s\n", describe(done.error()).c_str());
    return done ? 0 : 3;
}
