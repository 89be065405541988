module;
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import :ending;
import :execute;
import :formats;
import :given;
import :in_memory;
import :steps_for;

namespace camber::app {

namespace {

/// A config's cycles whose meshes and solutions stay in memory, by the names that files of theirs would have.
class CyclesInMemory {
  public:
    CyclesInMemory(const config::Pipeline& pipeline, int degree, const Solver& solver, const Host& host)
        : pipeline_(pipeline), degree_(degree), solver_(solver), host_(host) {}

    Outcome<AdaptedInMemory> run() {
        for (int cycle = 0; cycle <= pipeline_.adapt.cycles; ++cycle) {
            auto made = make(cycle);
            if (!made) return fail(made.error());
            const bool is_valid = made->has_valid_elements;
            if (run::row_of_result(rows_, pipeline_.adapt) + 1 == rows_.size()) result_ = std::move(*made);
            if (!is_valid) {
                result_->holds_what_was_asked = false;
                reason_ = fmt::format("the mesh of cycle {} has elements that are not certified valid", cycle);
                break;
            }
            reason_ = run::reason_to_end(rows_, pipeline_.adapt);
            if (!reason_.empty()) break;
        }
        for (std::string& note : run::notes_on_result(rows_, pipeline_.adapt))
            result_->notices.push_back(std::move(note));
        return AdaptedInMemory{std::move(*result_), run::cycles_json(rows_), std::move(reason_)};
    }

  private:
    [[nodiscard]] run::CycleFiles names(int cycle) const {
        return run::files_of_cycle(pipeline_, std::string(config::in_memory) + run::name_of_cycle(cycle));
    }

    Outcome<MadeInMemory> make(int cycle) {
        const run::CycleFiles into = names(cycle);
        auto made = mesh_of(cycle, into);
        if (!made) return fail(made.error());
        run::CycleRow row = run::row_of(cycle, pipeline_, *made);
        MadeInMemory now = made_of(std::move(made->run), input_);
        if (!made->miss.empty()) {
            now.holds_what_was_asked = false;
            now.notices.push_back(made->miss);
        }
        const bool is_solved = solver_ && now.has_valid_elements;
        if (is_solved) {
            auto solved = solver_(now.mesh, now.solution, cycle);
            if (!solved) return fail(solved.error());
            now.solution = std::move(*solved);
        }
        const auto fields =
            is_solved ? std::span<const run::NamedField>(now.solution) : std::span<const run::NamedField>();
        const auto done =
            run::add_errors(row, now.mesh.mesh, fields, pipeline_, {.threads = pipeline_.threads, .stop = host_.stop});
        if (!done) return fail(done.error());
        keep(cycle, into, now);
        rows_.push_back(row);
        return now;
    }

    /// Cycles go on from the one before, and from the first mesh as the geometry.
    void keep(int cycle, const run::CycleFiles& into, const MadeInMemory& now) {
        if (cycle > 1) {
            values_.meshes.erase(names(cycle - 1).mesh);
            values_.solutions.erase(names(cycle - 1).solution);
        }
        values_.meshes[into.mesh] = now.mesh;
        if (solver_) values_.solutions[into.solution] = now.solution;
    }

    Outcome<run::CycleRun> mesh_of(int cycle, const run::CycleFiles& into) {
        const config::Pipeline pipeline = cycle == 0
                                              ? run::first_pipeline(pipeline_, into)
                                              : run::cycle_pipeline(pipeline_, cycle, names(0), names(cycle - 1), into);
        Host host = host_;
        for (const auto& [name, mesh] : values_.meshes) host.given.meshes.insert_or_assign(name, mesh);
        for (const auto& [name, solution] : values_.solutions) host.given.solutions.insert_or_assign(name, solution);
        if (const auto* const file = std::get_if<config::FilePath>(&pipeline.input.source))
            if (const auto found = host.given.meshes.find(file->path); found != host.given.meshes.end())
                input_ = found->second;
        const bool is_input = cycle == 0 || pipeline.input == pipeline_.input;
        const Fit fit = [this, cycle](config::Pipeline asked, const AnyMesh& mesh) -> Outcome<config::Pipeline> {
            if (degree_ == 1 && run::plan_size(mesh).degree == 2)
                return fail(ErrorKind::input, "the mesh is of degree 2, and one of degree 1 is asked for", {}, {},
                            "give the straight one, or leave the degree out");
            return run::fitted_to(mesh, std::move(asked), cycle);
        };
        return run::run_cycle(pipeline, rows_, [&](const config::Pipeline& tried) {
            Written none;
            return execute(tried, none, is_input ? fit : Fit{}, host);
        });
    }

    const config::Pipeline& pipeline_;
    int degree_;
    const Solver& solver_;
    const Host& host_;
    Given values_;  ///< meshes and solutions of cycles
    DecodedMesh input_;
    std::vector<run::CycleRow> rows_;
    std::optional<MadeInMemory> result_;
    std::string reason_;
};

}  // namespace

namespace {

/// The outputs that are files: of cycles in memory the last mesh and its report. Errors: usage.
Outcome<Done> check_files(const config::Output& files) {
    for (const std::string& path : {files.vtu, files.metric, files.solution, files.plots, files.page})
        if (!path.empty())
            return fail(ErrorKind::usage, "is an output of cycles whose meshes are files", path, {},
                        "leave it out, or use camber run");
    return check_outputs(files);
}

Outcome<Done> write_files(const config::Output& files, const MadeInMemory& made, const Host& host) {
    if (!files.report.empty())
        if (auto done = write_text(files.report, made.report); !done) return done;
    if (files.mesh.empty()) return Done{};
    return write_from_memory(made.mesh, made.solution, files.mesh, files.format, host).map([](const auto&) {
        return Done{};
    });
}

}  // namespace

Outcome<AdaptedInMemory> adapt_in_memory(config::Pipeline pipeline, int degree, const Solver& solver, Host host) {
    const config::Output files = files_of(pipeline.output);
    if (auto possible = check_files(files); !possible) return fail(possible.error());
    if (solver) pipeline.adapt.solve = {std::string(config::in_memory) + "solver"};
    pipeline.output.metric = std::string(config::in_memory) + "metric.sol";
    pipeline.output.solution = std::string(config::in_memory) + "carried.sol";
    if (auto possible = run::check_cycles(pipeline); !possible) return fail(possible.error());
    auto made = CyclesInMemory(pipeline, degree, solver, host).run();
    if (made)
        if (auto done = write_files(files, made->result, host); !done) return fail(done.error());
    return made;
}

}  // namespace camber::app
