// Accuracy and cost of recovered derivatives. Solves −Δu = f for a known u with isoparametric P2 elements on boxes of
// three sizes. Gradient, Hessian and third derivatives of the solution are recovered at the vertices and compared with
// those of u:
//
//     recovery [--solution smooth|tanh|exp|wall] [--dimension 2|3] [--values
//     solved|interpolated|linear|linear-interpolated]
//              [--delaunay] [--bent 0.03] [--rings 2] [--core 0.3] [--boundary-rings 3] [--cells N] [--threads 1]
//
// Errors are relative, (Σ |T − T_u|² / Σ |T_u|²)^½, over the inner vertices and over the boundary vertices. The number
// in brackets is the order of convergence from the previous size.
// `tanh` is an oblique layer of thickness 0.1 (2D) or 0.2 (3D) through the box. `exp` is a layer of thickness 0.05 at a
// wall, on cells that grow by a factor of 20. `wall` is a layer of thickness 0.002 on cells that grow by a factor of
// 1000.
// `interpolated` uses the nodal values of u. `linear` solves with elements of degree 1, which have no third
// derivatives. `--bent` maps the box to itself and bends all inner edges.
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <functional>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.interpolation;
import camber.recovery;
import camber.shapes;

#include "recovery_systems.hpp"

using namespace camber;
using namespace poisson;

namespace {

struct Arguments {
    std::string solution = "smooth", values = "solved";
    int dimension = 2, cells = 0, threads = 1;
    bool delaunay = false;
    double bent = 0;
    RecoveryOptions recovery;
};

/// f(a·x) with f, f', f'', f'''.
template <int D>
struct Ridge {
    Vec<D> a;
    std::function<std::array<double, 4>(double)> f;
};
template <int D>
using Ridges = std::vector<Ridge<D>>;

template <int D>
Vec<D> first_of(const std::array<double, 3>& c) {
    Vec<D> v;
    for (int i = 0; i < D; ++i) v[i] = c[static_cast<std::size_t>(i)];
    return v;
}

template <int D>
Ridges<D> chosen(const std::string& name) {
    const auto exponential = [](double s) {
        const double e = std::exp(s);
        return std::array{e, e, e, e};
    };
    if (name == "smooth")
        return {{first_of<D>({4, 2.6, 1.4}),
                 [](double s) { return std::array{std::sin(s), std::cos(s), -std::sin(s), -std::cos(s)}; }},
                {first_of<D>({-0.4, 0.55, 0.85}), exponential}};
    if (name == "exp") return {{first_of<D>({-20, 0, 0}), exponential}};
    if (name == "wall") return {{first_of<D>({-500, 0, 0}), exponential}};
    const double delta = D == 2 ? 0.1 : 0.2;
    return {{normalised(first_of<D>({2, 1, 0.7})) / delta, [delta](double s) {
                 const double t = std::tanh(s - 0.7 / delta), d = 1 - t * t;
                 return std::array{t, d, -2 * t * d, (6 * t * t - 2) * d};
             }}};
}

template <int D>
KnownSolution<D> known(const Ridges<D>& ridges) {
    return {.value =
                [=](const Vec<D>& x) {
                    double u = 0;
                    for (const auto& r : ridges) u += r.f(dot(r.a, x))[0];
                    return u;
                },
            .source =
                [=](const Vec<D>& x) {
                    double f = 0;
                    for (const auto& r : ridges) f -= r.f(dot(r.a, x))[2] * norm_squared(r.a);
                    return f;
                }};
}

/// Returns a box: a jittered lattice cut along random diagonals, or the Delaunay triangulation of its vertices. For
/// `exp` the cells are smaller near the layer.
template <int D>
Outcome<QuadraticMesh<D>> box(int cells, const Arguments& arguments) {
    BoxOptions<D> options;
    options.cells.fill(cells);
    if (arguments.solution == "exp") options.grading[0] = 20;
    if (arguments.solution == "wall") options.grading[0] = 1000;
    auto mesh = generate<D>(options);
    if (!mesh) return fail(mesh.error());
    if (arguments.delaunay) {
        auto elements = delaunay<D>(mesh->points.view(), Noise{1});
        if (!elements) return fail(elements.error());
        mesh->facets = {};
        mesh->elements.references = Buffer<Reference>(elements->size(), 1);
        mesh->elements.vertices = std::move(*elements);
    }
    auto curved = elevate(std::move(*mesh), Execution{});
    if (!curved || arguments.bent == 0) return curved;
    const auto moved = [&](Vec<D> x) {
        double bump = arguments.bent;
        for (int i = 0; i < D; ++i) bump *= std::sin(std::numbers::pi * x[i]);
        const Vec<D> before = x;
        for (int i = 0; i < D; ++i) x[i] += bump * std::sin(2 * std::numbers::pi * before[(i + 1) % D] + i);
        return x;
    };
    auto points = take(std::move(curved->linear.points));
    for (auto& p : points) p = moved(p);
    auto nodes = take(std::move(curved->mid_nodes));
    for (auto& n : nodes) n.point = moved(n.point);
    curved->linear.points = std::move(points);
    curved->mid_nodes = std::move(nodes);
    return curved;
}

/// Returns the numbering restricted to the vertices.
Numbering of_vertices(Numbering numbering, std::size_t vertices) {
    numbering.unknown_of.resize(vertices);
    numbering.unknowns = 0;
    for (int& unknown : numbering.unknown_of)
        if (unknown >= 0) unknown = numbering.unknowns++;
    return numbering;
}

struct Values {
    Column<double> column;
    std::vector<std::uint8_t> on_boundary;  ///< one mark per vertex
    int unknowns = 0;
};

template <int D>
Outcome<Values> values_on(const QuadraticMesh<D>& mesh, const KnownSolution<D>& solution, const std::string& kind) {
    const bool linear = kind.starts_with("linear");
    auto numbering = number_nodes(mesh, Execution{});
    if (!numbering) return fail(numbering.error());
    const std::size_t vertices = mesh.linear.points.size();
    if (linear) numbering = of_vertices(std::move(*numbering), vertices);
    const std::size_t nodes = numbering->unknown_of.size();
    Values out;
    for (std::size_t v = 0; v < vertices; ++v) out.on_boundary.push_back(numbering->unknown_of[v] == prescribed);
    Eigen::VectorXd values(static_cast<Eigen::Index>(nodes));
    for (std::size_t n = 0; n < nodes; ++n)
        values[static_cast<Eigen::Index>(n)] =
            solution.value(n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point);
    if (kind == "solved" || kind == "linear") {
        const auto [matrix, right] = linear ? assemble_linear(mesh.linear, solution, *numbering, values)
                                            : assemble(mesh, basis_rule<D>(4), solution, *numbering, values);
        const auto solved = solve(matrix, right, 1e-12);
        if (!solved) return fail(solved.error());
        for (std::size_t n = 0; n < nodes; ++n)
            if (const int unknown = numbering->unknown_of[n]; unknown >= 0)
                values[static_cast<Eigen::Index>(n)] = solved->values[unknown];
        out.unknowns = numbering->unknowns;
    }
    out.column = Buffer<double>(values.data(), values.data() + nodes);
    return out;
}

/// Σ |error|² and Σ |exact|² for the three orders.
struct Sums {
    std::array<double, 3> errors{}, exact{};
    [[nodiscard]] double relative(std::size_t order) const { return std::sqrt(errors[order] / exact[order]); }
};

double squared(double x) { return x * x; }

template <int D>
void add(Sums& sums, const RecoveredDerivatives<D>& recovered, std::size_t row, const Ridges<D>& ridges,
         const Vec<D>& x) {
    Vec<D> g;
    Sym<D> h;
    CubicForm<D> t;
    for (const auto& r : ridges) {
        const auto f = r.f(dot(r.a, x));
        for (int i = 0; i < D; ++i) {
            g[i] += f[1] * r.a[i];
            for (int j = 0; j <= i; ++j) {
                h(i, j) += f[2] * r.a[i] * r.a[j];
                for (int k = 0; k <= j; ++k) t(i, j, k) += f[3] * r.a[i] * r.a[j] * r.a[k];
            }
        }
    }
    const auto& field = recovered.fields[0];
    sums.errors[0] += norm_squared(field.gradients[row] - g);
    sums.exact[0] += norm_squared(g);
    sums.errors[1] += squared(norm(field.hessians[row] - h));
    sums.exact[1] += squared(norm(h));
    if (field.thirds.empty()) return;
    sums.errors[2] += squared(norm(field.thirds[row] + -1.0 * t));
    sums.exact[2] += squared(norm(t));
}

struct Line {
    double h = 0;
    Sums inside, boundary;
};

void print(const Line& line, const std::optional<Line>& coarser, int orders) {
    for (const Sums Line::* part : {&Line::inside, &Line::boundary})
        for (int k = 0; k < orders; ++k) {
            const double error = (line.*part).relative(static_cast<std::size_t>(k));
            std::printf(" %.2f %%", 100 * error);
            if (coarser)
                std::printf(" (%.1f)", std::log((*coarser.*part).relative(static_cast<std::size_t>(k)) / error) /
                                           std::log(coarser->h / line.h));
            std::printf(" |");
        }
    std::printf("\n");
    std::fflush(stdout);
}

template <int D>
Outcome<Done> run(const Arguments& arguments) {
    const auto ridges = chosen<D>(arguments.solution);
    std::vector<int> sizes = D == 2 ? std::vector{32, 64, 128} : std::vector{8, 14, 28};
    if (arguments.cells > 0) sizes = {arguments.cells};
    const bool linear = arguments.values.starts_with("linear");
    std::printf(
        "%s, %s, %dD%s%s\n\n| cells | unknowns | solved, s | rows per CPU second | lower degree | gradient inside "
        "| Hessian |%s "
        "gradient on the boundary | Hessian |%s\n|---|---|---|---|---|---|---|%s---|---|%s\n",
        arguments.solution.c_str(), arguments.values.c_str(), D, arguments.delaunay ? ", Delaunay" : "",
        arguments.bent != 0 ? ", bent" : "", linear ? "" : " third |", linear ? "" : " third |", linear ? "" : "---|",
        linear ? "" : "---|");
    std::optional<Line> coarser;
    for (const int cells : sizes) {
        const auto mesh = box<D>(cells, arguments);
        if (!mesh) return fail(mesh.error());
        const auto begin = std::chrono::steady_clock::now();
        const auto values = values_on(*mesh, known<D>(ridges), arguments.values);
        if (!values) return fail(values.error());
        const std::chrono::duration<double> solving = std::chrono::steady_clock::now() - begin;
        const std::clock_t recovery_begin = std::clock();
        const auto recovered = recover_derivatives<D>(*mesh, std::span(&values->column, 1), arguments.recovery,
                                                      Execution{.threads = arguments.threads});
        if (!recovered) return fail(recovered.error());
        const double recovering = static_cast<double>(std::clock() - recovery_begin) / CLOCKS_PER_SEC;
        Line line{1.0 / cells, {}, {}};
        for (std::size_t v = 0; v < mesh->linear.points.size(); ++v)
            add(values->on_boundary[v] != 0 ? line.boundary : line.inside, *recovered,
                recovered->rows.first(VertexId(v)), ridges, mesh->linear.points[v]);
        std::printf("| %d | %d | %.1f | %.0f | %zu |", cells, values->unknowns, solving.count(),
                    static_cast<double>(recovered->rows.size()) / recovering, recovered->lower_degree);
        print(line, coarser, linear ? 2 : 3);
        coarser = line;
    }
    std::printf("\n");
    return Done{};
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
    const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
    return result.ec == std::errc() && result.ptr == text.data() + text.size() && number >= 0;
}

bool read_option(std::string_view name, std::string_view value, Arguments& arguments) {
    if (name == "--dimension")
        return read_number(value, arguments.dimension) && (arguments.dimension == 2 || arguments.dimension == 3);
    if (name == "--cells") return read_number(value, arguments.cells);
    if (name == "--threads") return read_number(value, arguments.threads);
    if (name == "--bent") return read_number(value, arguments.bent);
    if (name == "--rings") return read_number(value, arguments.recovery.rings);
    if (name == "--max-rings") return read_number(value, arguments.recovery.max_rings);
    if (name == "--boundary-rings") return read_number(value, arguments.recovery.boundary_rings);
    if (name == "--core") return read_number(value, arguments.recovery.core);
    if (name == "--values") {
        arguments.values = value;
        return value == "solved" || value == "interpolated" || value == "linear" || value == "linear-interpolated";
    }
    arguments.solution = value;
    return name == "--solution" && (value == "smooth" || value == "tanh" || value == "exp" || value == "wall");
}

std::optional<Arguments> read_arguments(std::span<char*> words) {
    Arguments arguments;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string_view word = words[i];
        if (word == "--delaunay")
            arguments.delaunay = true;
        else if (++i == words.size() || !read_option(word, words[i], arguments))
            return {};
    }
    return arguments;
}

}  // namespace

int main(int argc, char** argv) {
    const auto arguments = read_arguments({argv + 1, static_cast<std::size_t>(argc - 1)});
    if (!arguments) {
        std::fprintf(stderr, "see the top of bench/recovery.cpp for the options\n");
        return 2;
    }
    const auto done = arguments->dimension == 2 ? run<2>(*arguments) : run<3>(*arguments);
    if (!done) std::fprintf(stderr, "%s\n", describe(done.error()).c_str());
    return done ? 0 : 1;
}
