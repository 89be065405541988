// The command adapt
module;
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.io;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

constexpr int usual_cycles = 8;

Outcome<Done> check_given(const AdaptArguments& a) {
    for (const std::string& setting : a.settings)
        if (setting.starts_with("adapt"))
            return fail(ErrorKind::usage, in_quotes(setting) + " is the verb's own argument", "--set", {},
                        "give --cycles and the like, or use camber run");
    const config::Adaptation& adapt = a.adapt;
    if (a.solution.given.empty() && !a.metric.metric && adapt.solve.empty() && adapt.exact.empty())
        return fail(ErrorKind::usage, "what is the mesh to be adapted to?", {}, {},
                    "give --solution, --metric, --solve or --field");
    if (!a.solution.given.empty() && !adapt.solve.empty())
        return fail(ErrorKind::usage, "and --solve are two solutions", "--solution", {}, "leave one of them out");
    return Done{};
}

/// What arguments say other than by default.
void put_given(const config::SolutionMetric& given, config::SolutionMetric& metric) {
    const config::SolutionMetric by_default;
    const auto put = [&](auto member) {
        if (given.*member != by_default.*member) metric.*member = given.*member;
    };
    put(&config::SolutionMetric::norm);
    put(&config::SolutionMetric::error_of);
    put(&config::SolutionMetric::min_size);
    put(&config::SolutionMetric::max_size);
    put(&config::SolutionMetric::max_anisotropy);
}

/// The pipeline of a cycle: nodes are placed by the solution where the metric is made of it, too.
config::Pipeline cycle_of(const AdaptArguments& a) {
    config::SolutionMetric by_solution;
    if (a.degree == 1) {
        // An expression has values at all nodes: its degree says nothing of the elements that it is for.
        const std::string& given = a.solution.given;
        const bool is_expression = a.adapt.solve.empty() && (given.empty() || !names_a_file(given));
        if (is_expression) by_solution.degree = 1;
        config::Pipeline straight = with_stages({config::Remesh{}});
        straight.metric = by_solution;
        return straight;
    }
    config::Curve curve;
    if (!a.metric.metric) curve.objective = Objective::solution;
    config::Pipeline curved = with_stages(
        {config::Elevate{}, config::Remesh{}, curve, config::Validate{}, config::Relax{}, config::Commit{}});
    if (!a.metric.metric) curved.metric = by_solution;
    return curved;
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(const AdaptArguments& a) {
    if (auto given = check_given(a); !given) return fail(given.error());
    auto pipeline = pipeline_of(cycle_of(a), a);
    if (!pipeline) return pipeline;
    if (auto* made = std::get_if<config::SolutionMetric>(&pipeline->metric)) put_given(a.of_solution, *made);
    if (auto set = set_metric(a.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(a.geometry, *pipeline); !set) return fail(set.error());
    pipeline->adapt = a.adapt;
    const bool is_of_first_mesh = a.adapt.solve.empty() && !pipeline->solution.file.empty();
    pipeline->adapt.cycles = a.cycles.value_or(is_of_first_mesh ? 1 : usual_cycles);
    if (a.adapt.solve.empty() && a.solution.given.empty() && !a.metric.metric)
        pipeline->solution.expression = a.adapt.exact;
    return pipeline;
}

int adapt_command(const AdaptArguments& arguments) {
    const auto pipeline = pipeline_of(arguments);
    if (!pipeline) return report_error(pipeline.error());
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    // What arguments gave is as sound as what a config says.
    if (auto sound = config::with_values(*pipeline, {}, "command line"); !sound) return report_error(sound.error());
    return run_or_plan_cycles(*pipeline, files_of(*pipeline, words_of_options),
                              {.from = arguments.from, .degree = arguments.degree == 1 ? 1 : 0}, arguments.dry_run);
}

int run_or_plan_cycles(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                       const CyclesChoice& choice, bool dry_run) {
    // Every cycle's mesh takes the place of the output: the input would be lost while it is still needed.
    std::vector<NamedFile> named = files;
    for (NamedFile& file : named) {
        if (file.role == Role::input_mesh) file.role = Role::input;
        if (file.path == standard_stream)
            return report_error({ErrorKind::usage,
                                 "cycles read and write their files again and again, which a stream cannot",
                                 file.word + " -",
                                 {},
                                 "give a file"});
    }
    if (auto distinct = check_named_files(named); !distinct) return report_error(distinct.error());
    if (!dry_run) return run_cycles(pipeline, choice);
    const auto text = plan_cycles(pipeline, choice);
    return text ? end_with(*text + "\n  nothing was done\n") : report_error(text.error());
}

namespace {

/// What is known of the solver's solution on a mesh.
struct Solved {
    DecodedMesh mesh;
    std::vector<NamedField> fields;
};

std::string last_line(const std::string& path) {
    const auto bytes = read_file(path);
    if (!bytes) return {};
    std::string_view text = as_text(*bytes);
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.remove_suffix(1);
    constexpr std::size_t most = 200;
    text = text.substr(text.rfind('\n') + 1);
    return std::string(text.substr(0, most));
}

bool same_ending(const std::string& a, const std::string& b) {
    return std::filesystem::path(a).extension() == std::filesystem::path(b).extension();
}

Outcome<Done> copied(const std::string& from, const std::string& to) {
    auto bytes = read_file(from);
    if (!bytes) return fail(bytes.error());
    const std::span<const std::byte> all(*bytes);
    return write_file(to, {&all, 1});
}

Fit fit_of(const CyclesChoice& choice, int cycle) {
    return
        [degree = choice.degree, cycle](config::Pipeline pipeline, const AnyMesh& mesh) -> Outcome<config::Pipeline> {
            if (degree == 1 && run::plan_size(mesh).degree == 2)
                return fail(ErrorKind::input, "the mesh is of degree 2, and one of degree 1 is asked for", {}, {},
                            "give the straight one, or leave --degree 1 out");
            return run::fitted_to(mesh, std::move(pipeline), cycle);
        };
}

class Cycles {
  public:
    Cycles(const config::Pipeline& pipeline, const CyclesChoice& choice, CycleFolders folders)
        : pipeline_(pipeline), choice_(choice), folders_(std::move(folders)) {}

    /// The exit code.
    int run() {
        say(run::cycles_head(pipeline_.adapt));
        for (const run::CycleRow& row : folders_.rows()) say(run::cycles_line(row, pipeline_.adapt));
        int code = 0;
        auto groups = folders_.groups();
        if (!groups) return report_error(groups.error());
        groups_ = std::move(*groups);
        std::optional<std::size_t> delivered;
        for (int cycle = static_cast<int>(folders_.rows().size()); cycle <= pipeline_.adapt.cycles; ++cycle) {
            auto is_valid = make(cycle);
            if (!is_valid) return report_error(told(is_valid.error(), cycle));
            const std::size_t result = run::row_of_result(folders_.rows(), pipeline_.adapt);
            if (delivered != result)
                if (auto done = deliver(folders_.rows()[result].cycle); !done)
                    return report_error(told(done.error(), cycle + 1));
            delivered = result;
            say(run::cycles_line(folders_.rows().back(), pipeline_.adapt));
            if (auto said = out_.finish(); !said) return report_error(said.error());
            if (!*is_valid) {
                tell(fmt::format("the mesh of cycle {} has elements that are not certified valid: {}", cycle,
                                 cycle == 0 ? "mend it first (camber repair)"
                                            : "no cycle goes on from there, and the outputs are those of the mesh "
                                              "before"));
                code = 1;
                break;
            }
            reason_ = run::reason_to_end(folders_.rows(), pipeline_.adapt);
            if (!reason_.empty()) break;
        }
        return end(code);
    }

  private:
    void say(std::string_view text) {
        if (prints_notes()) out_.print(text);
    }

    /// What is worth knowing of the result, and what it misses; the exit code.
    int end(int code) {
        for (const Notice& notice : losses_)
            if (told_.insert(notice.what).second) tell_notice(notice);
        if (code == 0) {
            const auto& rows = folders_.rows();
            for (const std::string& note : run::notes_on_result(rows, pipeline_.adapt)) tell_note(note);
            for (const std::string& miss : rows[run::row_of_result(rows, pipeline_.adapt)].misses) {
                tell(miss);
                code = 1;
            }
        }
        say("\n" + (reason_.empty() ? std::string() : "  " + reason_ + "\n") + what_was_written());
        const auto said = out_.finish();
        return said ? code : report_error(said.error());
    }

    /// Makes the mesh of a cycle and the solver's solution on it; returns whether all of its elements are valid,
    /// without which no other cycle follows.
    Outcome<bool> make(int cycle) {
        const auto folder = folders_.part_of_cycle(cycle);
        if (!folder) return fail(folder.error());
        const auto into = run::files_of_cycle(pipeline_, *folder);
        auto made = mesh_of(cycle, into);
        if (!made) return fail(made.error());
        const AnyMesh& mesh = made->run.mesh;
        if (cycle == 0) {
            groups_ = run::groups_of(mesh);
            if (auto stored = folders_.store_groups(groups_); !stored) return fail(stored.error());
        }
        run::CycleRow row = run::row_of(cycle, pipeline_, *made);
        solved_.reset();
        const bool is_valid = row.is_valid;
        if (!pipeline_.adapt.solve.empty() && is_valid)
            if (auto done = solve(cycle, into, row); !done) return fail(done.error());
        const auto fields = solved_ ? std::span<const NamedField>(solved_->fields) : std::span<const NamedField>();
        const auto done = run::add_errors(row, solved_ ? solved_->mesh.mesh : mesh, fields, pipeline_,
                                          {.threads = pipeline_.threads, .stop = stop_on_signals()});
        if (!done) return fail(done.error());
        if (auto added = folders_.add(row, std::filesystem::path(into.view).filename().string()); !added)
            return fail(added.error());
        losses_ = losses_of(mesh);
        return is_valid;
    }

    [[nodiscard]] std::vector<Notice> losses_of(const AnyMesh& mesh) const {
        const std::string& to = pipeline_.output.mesh;
        if (to.empty()) return {};
        const auto format = format_of_mesh(to, pipeline_.output.format, format_of_input(to));
        return format ? (*format)->losses(mesh) : std::vector<Notice>{};
    }

    Outcome<run::CycleRun> mesh_of(int cycle, const run::CycleFiles& into) {
        const auto files = [&](int k) { return run::files_of_cycle(pipeline_, folders_.of_cycle(k)); };
        const config::Pipeline pipeline = cycle == 0
                                              ? run::first_pipeline(pipeline_, into)
                                              : run::cycle_pipeline(pipeline_, cycle, files(0), files(cycle - 1), into);
        const bool is_input = cycle == 0 || pipeline.input == pipeline_.input;
        auto made = run::run_cycle(pipeline, folders_.rows(), [&](const config::Pipeline& tried) {
            Host host;
            host.names = NamesOfGroups::by_the_caller;
            if (!is_input) host.given.groups = groups_;
            Written written;
            return execute(tried, written, is_input ? fit_of(choice_, cycle) : Fit{}, std::move(host));
        });
        if (!made) return made;
        for (const std::string& notice : made->run.report.notices)
            if (told_.insert(notice).second)
                tell_notice({notice, std::ranges::find(made->run.details, notice) != made->run.details.end()});
        return made;
    }

    Outcome<Done> solve(int cycle, const run::CycleFiles& into, run::CycleRow& row) {
        const auto words = run::solver_command(pipeline_.adapt, cycle, into);
        const Execution execution{.threads = pipeline_.threads, .stop = stop_on_signals()};
        const auto ended = run_command_line(words, pipeline_.adapt.timeout, into.said, execution);
        if (!ended) return fail(ended.error());
        row.solve_seconds = ended->seconds;
        if (ended->end != CommandEnd::done) return fail(failed(*ended, words, into.said, cycle));
        std::error_code none;
        if (!std::filesystem::exists(into.solution, none))
            return fail(ErrorKind::input, fmt::format("was not written by the solver of cycle {}", cycle),
                        into.solution, {}, "see what it said in " + into.said);
        if (auto read = read_solved(into, execution); !read) return read;
        return write_nodal_fields(solved_->mesh, solved_->fields, into.view, {}, execution);
    }

    Outcome<Done> read_solved(const run::CycleFiles& from, const Execution& execution) {
        auto mesh = read_mesh(from.mesh, pipeline_.input.flat, execution);
        if (!mesh) return fail(mesh.error());
        name_references(mesh->mesh, groups_);
        std::vector<Notice> notices;
        auto fields = read_nodal_fields(*mesh, from.solution, pipeline_.solution.fields, notices, execution);
        if (!fields) return fail(fields.error());
        solved_ = Solved{std::move(*mesh), std::move(*fields)};
        return Done{};
    }

    [[nodiscard]] Error failed(const CommandResult& ended, const std::vector<std::string>& words,
                               const std::string& said, int cycle) const {
        const std::string last = last_line(said);
        const std::string how = ended.end == CommandEnd::out_of_time
                                    ? fmt::format("took more than {:g} s", pipeline_.adapt.timeout)
                                    : "failed: " + ended.how;
        return {ErrorKind::input,
                fmt::format("the solver of cycle {} {}{}", cycle, how, last.empty() ? "" : ": " + last),
                words.front(),
                {},
                "all that it said is in " + said};
    }

    /// What a cycle made, as the config's outputs.
    Outcome<Done> deliver(int cycle) {
        const config::Output& output = pipeline_.output;
        const auto made = run::files_of_cycle(pipeline_, folders_.of_cycle(cycle));
        if (!pipeline_.adapt.solve.empty() && cycle != folders_.rows().back().cycle)
            if (auto read = read_solved(made, {.threads = pipeline_.threads}); !read) return read;
        const auto pair = [](const std::string& from, const std::string& to) -> Outcome<Done> {
            std::error_code none;
            if (from.empty() || to.empty() || !std::filesystem::exists(from, none)) return Done{};
            return copied(from, to);
        };
        if (auto done = deliver_mesh(made, output.mesh, output.format); !done) return done;
        if (auto done = pair(made.report, output.report); !done) return done;
        if (auto done = pair(made.vtu, output.vtu); !done) return done;
        if (auto done = pair(made.metric, output.metric); !done) return done;
        if (auto done = pair(made.page, output.page); !done) return done;
        if (!output.plots.empty()) {
            const auto from = plot_files(made.plots), to = plot_files(output.plots);
            for (std::size_t i = 0; i < from.size(); ++i)
                if (auto done = pair(from[i], to[i]); !done) return done;
        }
        if (!solved_ || output.solution.empty()) return pair(made.carried, output.solution);
        return write_nodal_fields(solved_->mesh, solved_->fields, output.solution, {}, {.threads = pipeline_.threads});
    }

    Outcome<Done> deliver_mesh(const run::CycleFiles& made, const std::string& to, const std::string& name) {
        if (to.empty()) return Done{};
        const Execution execution{.threads = pipeline_.threads};
        const auto format = format_of_mesh(to, name, format_of_input(to));
        if (!format) return fail(format.error());
        const bool is_as_made = name.empty() && same_ending(made.mesh, to) && (*format)->shared_ending.empty();
        if (is_as_made && !((*format)->holds_fields && solved_)) return copied(made.mesh, to);
        if (solved_) return write_with_mesh(solved_->mesh, solved_->fields, **format, to, execution);
        auto mesh = read_mesh(made.mesh, pipeline_.input.flat, execution);
        if (!mesh) return fail(mesh.error());
        name_references(mesh->mesh, groups_);
        std::vector<Notice> notices;
        return write_with_mesh(*mesh, fields_at_nodes(*mesh, notices), **format, to, execution);
    }

    /// The format of the first mesh's file, where a mesh with this ending may be of several.
    [[nodiscard]] std::string_view format_of_input(const std::string& to) const {
        const auto* const file = std::get_if<config::FilePath>(&pipeline_.input.source);
        const MeshFormat* const by_ending = format_with_ending(mesh_formats(), to);
        if (file == nullptr || by_ending == nullptr || by_ending->shared_ending.empty()) return {};
        const auto bytes = read_file(file->path);
        const MeshFormat* const format = bytes ? format_with_content(mesh_formats(), *bytes) : nullptr;
        return format != nullptr ? format->name : std::string_view();
    }

    /// An error in a cycle, with what there is to go on from.
    [[nodiscard]] Error told(Error error, int cycle) const {
        if (cycle == 0 || !folders_.is_kept()) return error;
        const int last = cycle - 1;
        error.what += fmt::format("; cycles 0 to {} are whole in {}: --from {} goes on", last, folders_.path(), last);
        return error;
    }

    [[nodiscard]] std::string what_was_written() const {
        std::string text;
        const config::Output& output = pipeline_.output;
        text += wrote_rows(
            {output.mesh, output.vtu, output.metric, output.solution, output.report, output.plots, output.page});
        if (folders_.is_kept()) text += "  wrote " + folders_.path() + "/series.pvd and cycles.json beside it\n";
        return text;
    }

    const config::Pipeline& pipeline_;
    const CyclesChoice& choice_;
    CycleFolders folders_;
    StandardOutput out_;
    std::optional<Solved> solved_;  ///< of the cycle that was made or delivered last
    run::Groups groups_;            ///< names of references of the first mesh, and so of all
    std::vector<Notice> losses_;    ///< what the file of the result has no place for
    std::set<std::string> told_;    ///< notices
    std::string reason_;            ///< why they ended early
};

Outcome<CycleFolders> folders_of(const config::Pipeline& pipeline, const CyclesChoice& choice) {
    const std::string kept = kept_folder(pipeline);
    if (kept.empty() && choice.from)
        return fail(ErrorKind::usage, "there are no cycles to go on from: none are kept", "--from", {},
                    "give --folder");
    if (choice.from && *choice.from >= pipeline.adapt.cycles)
        return fail(ErrorKind::usage,
                    fmt::format("after cycle {} of {} there is nothing to do", *choice.from, pipeline.adapt.cycles),
                    "--from", {}, "ask for more cycles");
    if (kept.empty()) return CycleFolders::passing(pipeline.output.mesh);
    return choice.from ? CycleFolders::going_on(kept, *choice.from) : CycleFolders::anew(kept);
}

}  // namespace

std::string kept_folder(const config::Pipeline& pipeline) {
    if (!pipeline.adapt.folder.empty()) return pipeline.adapt.folder;
    if (pipeline.adapt.solve.empty() && !pipeline.output.mesh.empty()) return {};
    if (pipeline.output.mesh.empty()) return "camber.cycles";
    return std::filesystem::path(pipeline.output.mesh).replace_extension(".cycles").string();
}

int run_cycles(const config::Pipeline& pipeline, const CyclesChoice& choice) {
    if (auto possible = run::check_cycles(pipeline); !possible) return report_error(possible.error());
    if (auto possible = check_outputs(pipeline.output); !possible) return report_error(possible.error());
    auto folders = folders_of(pipeline, choice);
    if (!folders) return report_error(folders.error());
    return Cycles(pipeline, choice, std::move(*folders)).run();
}

Outcome<std::string> plan_cycles(const config::Pipeline& pipeline, const CyclesChoice& choice) {
    if (auto possible = run::check_cycles(pipeline); !possible) return fail(possible.error());
    config::Pipeline once = pipeline;
    once.adapt = {};
    // What the solver will say is not known: the first mesh's plan.
    if (!pipeline.adapt.solve.empty()) once = run::first_pipeline(pipeline, run::files_of_cycle(pipeline, ""));
    once.output = pipeline.output;
    auto text = plan(once, fit_of(choice, 1));
    if (!text) return text;
    const std::string kept = kept_folder(pipeline);
    *text += fmt::format("  at most {} such cycles{}{}\n", pipeline.adapt.cycles,
                         pipeline.adapt.solve.empty() ? "" : ", each after the solver",
                         kept.empty() ? "" : "; kept in " + kept);
    return text;
}

}  // namespace camber::app
