// Adaptation cycles: their pipelines, their end, their result and their table; adaptation in memory.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <rapidcheck.h>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.solution_metric;
import camber.transfer;
import camber.io;
import camber.shapes;
import camber.config;
import camber.recipes;
import camber.reports;

using namespace camber;
using namespace camber::testing;
using run::CycleRow;

namespace {

config::Pipeline adapting(std::string_view adapt, std::string_view more = "") {
    const std::string text = R"({"input": {"mesh": "wing.meshb"}, "metric": {"solution": {}}, "stages": ["elevate",
        "remesh", {"curve": {"objective": "solution"}}, "validate", "relax", "commit"],
        "output": {"mesh": "new.meshb", "solution": "v.sol"}, "adapt": )" +
                             std::string(adapt) + std::string(more) + "}";
    auto pipeline = config::read_pipeline(text, "test");
    REQUIRE_MESSAGE(pipeline, (pipeline ? "" : describe(pipeline.error())));
    return *pipeline;
}
constexpr const char* solving =
    R"({"cycles": 3, "complexity": [10, 20], "solve": ["flow", "{mesh}", "-o{solution}", "{cycle}"]})";

template <class S>
bool has_stage(const config::Pipeline& pipeline) {
    for (const config::Stage& stage : pipeline.stages)
        if (std::holds_alternative<S>(stage)) return true;
    return false;
}

CycleRow row(int cycle, double before, double after) {
    CycleRow outcome{.cycle = cycle, .unknowns = 10U, .elements = 5U, .solved = {}};
    outcome.unit_before = before;
    outcome.unit_edges = after;
    return outcome;
}

}  // namespace

TEST_CASE("the first mesh is curved without remeshing for a solver and unchanged without one") {
    const auto pipeline_of_cycles = adapting(solving);
    const auto into = run::files_of_cycle(pipeline_of_cycles, "c/cycle-000");
    const auto first = run::first_pipeline(pipeline_of_cycles, into);
    CHECK(has_stage<config::Elevate>(first));
    CHECK(has_stage<config::Curve>(first));
    CHECK_FALSE(has_stage<config::Remesh>(first));
    CHECK(std::holds_alternative<config::NaturalMetric>(first.metric));
    CHECK(first.output.mesh == "c/cycle-000/mesh.meshb");
    const auto without_solver = adapting(R"({"cycles": 3, "exact": "x"})");
    CHECK(run::first_pipeline(without_solver, run::files_of_cycle(without_solver, "c")).stages.empty());
}

TEST_CASE("a cycle uses the previous mesh and solution, the first boundary and its own complexity") {
    const auto pipeline_of_cycles = adapting(solving);
    const auto files = [&](const char* folder) { return run::files_of_cycle(pipeline_of_cycles, folder); };
    for (const int cycle : {1, 2, 3}) {
        const auto outcome =
            run::cycle_pipeline(pipeline_of_cycles, cycle, files("first"), files("before"), files("into"));
        CHECK(std::get<config::FilePath>(outcome.input.source).path == "before/mesh.meshb");
        CHECK(outcome.solution.file == "before/solution.sol");
        CHECK(std::get<config::FilePath>(outcome.geometry).path == "first/mesh.meshb");
        CHECK(std::get<config::SolutionMetric>(outcome.metric).complexity == (cycle == 1 ? 10 : 20));
        CHECK_FALSE(has_stage<config::Elevate>(outcome));
        CHECK(outcome.output.solution == "into/guess.sol");
        CHECK_FALSE(outcome.adapt.is_requested());
    }
    const auto without_solver = adapting(R"({"cycles": 3})", R"(, "solution": {"expression": "x*y"})");
    const auto first = run::cycle_pipeline(without_solver, 1, files("first"), files("before"), files("into"));
    CHECK(first.input == without_solver.input);
    CHECK(has_stage<config::Elevate>(first));
    const auto next = run::cycle_pipeline(without_solver, 2, files("first"), files("before"), files("into"));
    CHECK(std::get<config::FilePath>(next.input.source).path == "before/mesh.meshb");
    CHECK(next.solution.expression == "x*y");
}

TEST_CASE("the complexity by cycle also scales a metric that does not come from the solution") {
    auto pipeline_of_cycles = adapting(R"({"cycles": 2, "complexity": [7]})");
    pipeline_of_cycles.metric = config::ConstantMetric{.sizes = {0.1}, .tensor = {}};
    const auto files = run::files_of_cycle(pipeline_of_cycles, "c");
    const auto outcome = run::cycle_pipeline(pipeline_of_cycles, 2, files, files, files);
    REQUIRE(outcome.metric_operations.size() == 1);
    CHECK(std::get<config::Complexity>(outcome.metric_operations.front()).target == 7);
}

TEST_CASE("placeholders of the solver command are replaced by the files of the cycle") {
    const auto pipeline_of_cycles = adapting(solving);
    const auto words =
        run::solver_command(pipeline_of_cycles.adapt, 2, run::files_of_cycle(pipeline_of_cycles, "c/cycle-002"));
    CHECK(words == std::vector<std::string>{"flow", "c/cycle-002/mesh.meshb", "-oc/cycle-002/solution.sol", "2"});
}

TEST_CASE("a solution or metric file of the first mesh is rejected for several cycles") {
    const auto of_file = adapting(R"({"cycles": 2})", R"(, "solution": {"file": "u.sol"})");
    CHECK(run::check_cycles(of_file).error().where == "/solution/file");
    CHECK(run::check_cycles(adapting(R"({"cycles": 1})", R"(, "solution": {"file": "u.sol"})")));
    auto intersected = adapting(R"({"cycles": 2})");
    intersected.metric_operations.emplace_back(config::Intersect{config::FilePath{"m.sol"}});
    CHECK(run::check_cycles(intersected).error().where == "/metric_operations");
    CHECK(run::check_cycles(adapting(solving)));
}

TEST_CASE("cycles without an error end when the unit edge ratio stops improving") {
    const config::Adaptation adapt{.cycles = 9, .complexity = {10, 20}};
    std::vector<CycleRow> rows{row(0, 0, 0), row(1, 0.1, 0.9), row(2, 0.1, 0.9)};
    const auto reason = [&](double before) {
        auto all = rows;
        all.push_back(row(3, before, 0.9));
        return run::reason_to_end(all, adapt);
    };
    CHECK_MESSAGE(reason(0.1).empty(), "cycle 2 has another complexity");
    rows.push_back(row(3, 0.5, 0.9));
    rows.push_back(row(4, 0.8, 0.9));
    CHECK(run::reason_to_end(rows, adapt).empty());
    rows.push_back(row(5, 0.81, 0.9));
    CHECK_FALSE(run::reason_to_end(rows, adapt).empty());
    CHECK_MESSAGE(run::reason_to_end(rows, {.cycles = 9, .convergence_tolerance = 0}).empty(),
                  "tolerance 0 disables an early end");
    CHECK_MESSAGE(reason(0.1).empty(), "far from unit");
    std::vector<CycleRow> moving{row(2, 0.3, 0.9), row(3, 0.3, 0.9), row(4, 0.3, 0.9)};
    CHECK_MESSAGE(run::reason_to_end(moving, {.cycles = 9}).empty(), "meshes are far from unit in the next metric");
}

TEST_CASE("cycles end when the minimum error stops falling, and its mesh is the result") {
    property("the result of random errors is the cycle of minimum error", [](std::uint64_t seed) {
        Dice dice(seed);
        const config::Adaptation adapt{
            .cycles = 30, .complexity = {10, 20}, .convergence_tolerance = dice.uniform(0.02, 0.5)};
        std::vector<CycleRow> rows;
        std::vector<double> least;  // running minimum over the cycles of the last complexity
        for (int cycle = 0; cycle <= 12; ++cycle) {
            CycleRow outcome = row(cycle, 0.5, 0.9);
            outcome.complexity_target = cycle == 0 ? 0 : cycle == 1 ? 10 : 20;
            // Cycles 0 and 1 have smaller complexities: they may have the minimum error by chance and are never the
            // result.
            outcome.expected = std::exp(dice.uniform(-1, 1)) / (cycle + 1);
            rows.push_back(outcome);
            if (cycle < 2) continue;
            least.push_back(least.empty() ? *outcome.expected : std::min(least.back(), *outcome.expected));
            const CycleRow& result = rows[run::row_of_result(rows, adapt)];
            RC_ASSERT(result.cycle >= 2);
            RC_ASSERT(*result.expected == least.back());
            const std::size_t n = least.size();
            const bool has_settled = n > 2 && least[n - 1] >= (1 - adapt.convergence_tolerance) * least[n - 3];
            RC_ASSERT(run::reason_to_end(rows, adapt).empty() == !has_settled);
            RC_ASSERT(
                run::reason_to_end(rows, {.cycles = 30, .complexity = {10, 20}, .convergence_tolerance = 0}).empty());
            auto last = adapt;
            last.result = config::ResultOfCycles::last;
            RC_ASSERT(run::row_of_result(rows, last) + 1 == rows.size());
        }
    });
}

TEST_CASE("the result is the valid mesh of minimum error, or the last for a solver that gets {cycle}") {
    std::vector<CycleRow> rows{row(0, 0, 0), row(1, 0.5, 0.9), row(2, 0.5, 0.9), row(3, 0.5, 0.9)};
    for (std::size_t i = 1; i < rows.size(); ++i) {
        rows[i].expected = 4.0 - static_cast<double>(i);
        rows[i].interpolated = run::CycleError{static_cast<double>(i), 1};
    }
    const auto result = [&](const config::Adaptation& adapt) { return run::row_of_result(rows, adapt); };
    CHECK_MESSAGE(result({.cycles = 3}) == 1, "minimum interpolation error");
    CHECK_MESSAGE(result({.cycles = 3, .solve = {"flow", "{mesh}", "{solution}"}}) == 3, "minimum expected error");
    rows[3].is_valid = false;
    CHECK(result({.cycles = 3, .solve = {"flow", "{mesh}", "{solution}"}}) == 2);
    rows[3].is_valid = true;
    rows[1].expected = 0.5;
    CHECK(result({.cycles = 3, .solve = {"flow", "{mesh}", "{solution}"}}) == 1);
    const std::vector<std::string> of_cycle{"flow", "{mesh}", "{solution}", "-n{cycle}"};
    CHECK(result({.cycles = 3, .solve = of_cycle}) == 3);
    CHECK(result({.cycles = 3, .solve = of_cycle, .result = config::ResultOfCycles::best}) == 1);
    rows[1].misses = {"off by 1"};
    CHECK_MESSAGE(result({.cycles = 3}) == 2, "a mesh with a miss is the result only if all meshes have one");
    for (CycleRow& each : rows) each.error_of = ErrorQuantity::gradients;
    rows[3].interpolated = run::CycleError{9, 0.5};
    CHECK_MESSAGE(result({.cycles = 3}) == 3, "the error in H1");
    rows[1].misses.clear();
    rows[1].interpolated = run::CycleError{0.1, 0.1};
    rows[1].problem = "x";
    CHECK_MESSAGE(result({.cycles = 3}) == 3, "errors of another problem are not compared");
    const auto read = run::read_cycles(run::cycles_json(rows), "cycles.json");
    REQUIRE(read);
    CHECK((*read)[2].misses == rows[2].misses);
    CHECK((*read)[1].problem == "x");
}

TEST_CASE("notes report an earlier result and decreases of unit edges and minimum quality") {
    std::vector<CycleRow> rows{row(1, 0.5, 0.9), row(2, 0.5, 0.8), row(3, 0.5, 0.9)};
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].expected = i == 1 ? 1 : 2;
    rows[0].worst_quality = 0.5;
    rows[1].worst_quality = 0.2;
    const auto notes = run::notes_on_result(rows, {.cycles = 3});
    REQUIRE(notes.size() == 3);
    CHECK(notes[0].find("cycle 2") != std::string::npos);
    CHECK(notes[1].find("90.0 % in cycle 1 to 80.0 %") != std::string::npos);
    CHECK(notes[2].find("0.500 in cycle 1 to 0.200") != std::string::npos);
    rows.pop_back();
    rows[1] = row(2, 0.5, 0.9);
    rows[1].worst_quality = 0.5;
    CHECK(run::notes_on_result(rows, {.cycles = 3}).empty());
}

TEST_CASE("names of references are read back as written") {
    const run::Groups groups{{1, 6, "inlet"}, {2, -3, "say \"it\" / \xCE\xBB"}, {1, 6, ""}};
    const auto read = run::read_groups(run::groups_json(groups), "groups.json");
    REQUIRE(read);
    CHECK(*read == groups);
    for (const char* const text : {"", "{}", R"({"groups": [{"dimension": 1}]})"})
        CHECK(run::read_groups(text, "groups.json").error().where == "groups.json");
}

TEST_CASE("the table of cycles is read back as written") {
    CycleRow full = row(1, 0.25, 0.75);
    full.interpolated = run::CycleError{1e-3, 1e-2};
    full.solved = run::CycleError{2e-3, 3e-2};
    full.expected = 4e-5;
    full.seconds = 1.5;
    const std::vector<CycleRow> rows{row(0, 0, 0), full};
    const auto read = run::read_cycles(run::cycles_json(rows), "cycles.json");
    REQUIRE(read);
    CHECK(run::cycles_json(*read) == run::cycles_json(rows));
    REQUIRE(read->size() == 2);
    CHECK(read->back().solved->h1 == 3e-2);
    for (const char* text : {"", "{}", R"({"cycles": 3})", R"({"cycles": [{"cycle": "x"}]})"})
        CHECK(run::read_cycles(text, "cycles.json").error().where == "cycles.json");
    CHECK(run::series_of(rows, "view.vtu").find("cycle-001/view.vtu") != std::string::npos);
}

TEST_CASE("a cycle with invalid elements is repeated with a smaller step at most three times") {
    const auto pipeline_of_cycles = adapting(solving);
    const auto files = [&](const char* folder) { return run::files_of_cycle(pipeline_of_cycles, folder); };
    const auto pipeline = run::cycle_pipeline(pipeline_of_cycles, 2, files("0"), files("1"), files("2"));
    const std::vector<CycleRow> rows{{.cycle = 0, .elements = 3, .solved = {}},
                                     {.cycle = 1, .elements = 5, .solved = {}}};
    for (const std::size_t elements : {std::size_t{20}, std::size_t{5}, std::size_t{2}})
        for (int fails = 0; fails <= 5; ++fails) {
            std::vector<double> tried;
            const auto outcome = run::run_cycle(pipeline, rows, [&](const config::Pipeline& p) -> Outcome<run::Run> {
                const double complexity = std::get<config::SolutionMetric>(p.metric).complexity;
                tried.push_back(complexity);
                run::Run run;
                run.report.metric.emplace().complexity = complexity;
                run.report.mesh.elements = elements;
                run.report.validity.emplace().invalid = std::ssize(tried) <= fails ? 1 : 0;
                if (std::ssize(tried) <= fails) run.report.invalid_elements = {1};
                return run;
            });
            REQUIRE(outcome);
            CHECK(std::ssize(tried) == std::min(fails, 3) + 1);
            CHECK(std::ssize(outcome->run.report.notices) == std::min(fails, 3));
            CHECK(tried.front() == 20);
            CHECK(outcome->miss.empty() == (fails == 0 || fails > 3));
            for (std::size_t i = 1; i < tried.size(); ++i)
                CHECK((tried[i] < tried[i - 1]) == (elements >= 5));  // closer to the previous mesh, which has 5
                                                                      // elements
        }
}

namespace {

/// Solution with a front across the unit square.
double front(const Vec<2>& p) { return std::tanh((p.c[0] + p.c[1] - 1) / 0.1); }
constexpr const char* front_expression = "tanh((x+y-1)/0.1)";

std::vector<run::NamedField> front_on(const Mesh<2>& mesh) {
    Buffer<double> values;
    for (const Vec<2>& p : mesh.points) values.push_back(front(p));
    for (const auto& node : mesh.edge_nodes) values.push_back(front(node.point));
    return {{"u", FieldKind::scalar, {.degree = mesh.degree, .values = std::move(values)}}};
}

Mesh<2> square() { return as_mesh(must(generate(BoxOptions<2>{.cells = {6, 6}}, one_thread))); }

}  // namespace

TEST_CASE("adapt_mesh calls its solver on each mesh with the transferred previous solution") {
    for (const int degree : {1, 2}) {
        std::vector<std::size_t> guessed;
        const MeshSolver<2> solver = [&](const Mesh<2>& mesh, const std::vector<run::NamedField>& guess, int cycle) {
            CHECK(cycle == std::ssize(guessed));
            guessed.push_back(guess.empty() ? 0 : guess.front().field.values.size());
            if (cycle > 0) CHECK(guessed.back() == front_on(mesh).front().field.values.size());
            return Outcome<std::vector<run::NamedField>>(front_on(mesh));
        };
        const AdaptMeshOptions options{.degree = degree,
                                       .cycles = {.cycles = 2, .complexity = {60}, .exact = front_expression}};
        const auto outcome = must(adapt_mesh<2>(square(), solver, options, without_wrapper(one_thread)));
        REQUIRE(outcome.cycles.rows.size() == 3);
        CHECK(guessed.size() == 3);
        CHECK(outcome.mesh.degree == degree);
        CHECK(outcome.report.meets_requirements());
        CHECK(outcome.solution.front().field == front_on(outcome.mesh).front().field);
        const std::vector<CycleRow>& rows = outcome.cycles.rows;
        CHECK(rows.back().solved->l2 < rows.front().solved->l2 / 2);
        CHECK(rows.back().seconds > 0);
    }
}

TEST_CASE("adapt_mesh adapts to an expression and rejects fields and meshes of a wrong degree") {
    AdaptMeshOptions options{.cycles = {.cycles = 2, .complexity = {60}, .exact = front_expression}};
    const auto outcome = must(adapt_mesh<2>(square(), front_expression, options, without_wrapper(one_thread)));
    const std::vector<CycleRow>& rows = outcome.cycles.rows;
    CHECK(rows.back().interpolated->l2 < rows.front().interpolated->l2 / 10);
    CHECK(outcome.cycles.result > 0);
    const MeshSolver<2> wrong = [](const Mesh<2>& mesh, const auto&, int) {
        auto fields = front_on(mesh);
        fields.front().field.degree = 2;
        return Outcome<std::vector<run::NamedField>>(std::move(fields));
    };
    CHECK(adapt_mesh<2>(square(), wrong, {.degree = 1}, without_wrapper(one_thread)).error().where == "field u");
    CHECK(adapt_mesh<2>(outcome.mesh, front_expression, {.degree = 1}, without_wrapper(one_thread)).error().kind ==
          ErrorKind::input);
    options.cycles.convergence_tolerance = 2;
    CHECK(adapt_mesh<2>(square(), front_expression, options, without_wrapper(one_thread)).error().kind ==
          ErrorKind::usage);
}
