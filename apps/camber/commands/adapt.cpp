module;
#include <algorithm>
#include <array>
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

Outcome<Done> check_inputs(const AdaptArguments& a) {
    for (const std::string& setting : a.settings)
        if (setting.starts_with("adapt"))
            return fail(ErrorKind::usage, in_quotes(setting) + " is set by an option of this verb", "--set", {},
                        "use --cycles and similar options, or camber run");
    const config::Adaptation& adapt = a.adapt;
    if (a.solution.input_file.empty() && !a.metric.metric && adapt.solve.empty() && adapt.exact.empty())
        return fail(ErrorKind::usage, "no adaptation target is specified", {}, {},
                    "give --solution, --metric, --solve or --field");
    if (!a.solution.input_file.empty() && !adapt.solve.empty())
        return fail(ErrorKind::usage, "cannot be combined with --solve", "--solution", {}, "give one of them");
    return Done{};
}

void apply_options(const config::SolutionMetric& specified, config::SolutionMetric& metric) {
    const config::SolutionMetric by_default;
    const auto put = [&](auto member) {
        if (specified.*member != by_default.*member) metric.*member = specified.*member;
    };
    put(&config::SolutionMetric::norm);
    put(&config::SolutionMetric::error_of);
    put(&config::SolutionMetric::min_size);
    put(&config::SolutionMetric::max_size);
    put(&config::SolutionMetric::max_anisotropy);
}

config::Pipeline cycle_of(const AdaptArguments& a) {
    config::SolutionMetric by_solution;
    // An expression has values at all nodes of meshes of any degree. The argument's degree decides.
    const std::string& specified = a.solution.input_file;
    const bool is_expression = a.adapt.solve.empty() && (specified.empty() || !names_a_file(specified));
    if (a.degree == 1 && is_expression) by_solution.degree = 1;
    const bool is_by_solution = a.degree == 1 || !a.metric.metric;
    return run::steps_of_cycles(a.degree, is_by_solution ? config::Metric(by_solution) : config::NaturalMetric{});
}

}  // namespace

Outcome<config::Pipeline> pipeline_of(const AdaptArguments& a) {
    if (auto specified = check_inputs(a); !specified) return fail(specified.error());
    auto pipeline = pipeline_of(cycle_of(a), a);
    if (!pipeline) return pipeline;
    if (auto* outcome = std::get_if<config::SolutionMetric>(&pipeline->metric)) apply_options(a.of_solution, *outcome);
    if (auto set = set_metric(a.metric, *pipeline); !set) return fail(set.error());
    if (auto set = set_geometry(a.geometry, *pipeline); !set) return fail(set.error());
    pipeline->adapt = a.adapt;
    const bool is_of_first_mesh = a.adapt.solve.empty() && !pipeline->solution.file.empty();
    pipeline->adapt.cycles = a.cycles.value_or(is_of_first_mesh ? 1 : usual_cycles);
    if (a.adapt.solve.empty() && a.solution.input_file.empty() && !a.metric.metric)
        pipeline->solution.expression = a.adapt.exact;
    return pipeline;
}

Outcome<int> adapt_command(const AdaptArguments& arguments) {
    const auto pipeline = pipeline_of(arguments);
    if (!pipeline) return fail(pipeline.error());
    // Option values have the same limits as values of a config.
    if (auto sound = config::with_values(*pipeline, {}, "command line"); !sound) return fail(sound.error());
    if (arguments.print_config) return end_with(config::write_pipeline(*pipeline));
    return run_or_plan_cycles(*pipeline, files_of(*pipeline, words_of_options),
                              {.from = arguments.from, .degree = arguments.degree == 1 ? 1 : 0}, arguments.dry_run);
}

namespace {

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

run::InputDegree required_by(const CyclesChoice& choice) { return {choice.degree, "--degree 1"}; }

class CyclesInFolders final : public run::CycleStore {
  public:
    CyclesInFolders(const config::Pipeline& pipeline, CycleFolders folders)
        : pipeline_(pipeline), folders_(std::move(folders)) {}

    [[nodiscard]] std::vector<run::CycleRow> rows() const override { return folders_.rows(); }
    [[nodiscard]] run::CycleFiles files(int cycle) const override {
        return run::files_of_cycle(pipeline_, folders_.of_cycle(cycle));
    }
    Outcome<run::CycleFiles> begin(int cycle) override {
        cycle_ = cycle;
        solved_.reset();
        return folders_.part_of_cycle(cycle).map(
            [&](const std::string& part) { return run::files_of_cycle(pipeline_, part); });
    }
    Outcome<run::Run> run(const config::Pipeline& pipeline, const Fit& fit) override {
        Host host;
        host.names = NamesOfGroups::by_the_caller;
        if (!fit) host.memory_inputs.groups = folders_.groups();
        Written written;
        auto outcome = execute(pipeline, written, fit, std::move(host));
        if (!outcome || cycle_ > 0) return outcome;
        if (auto stored = folders_.store_groups(run::groups_of(outcome->mesh)); !stored) return fail(stored.error());
        return outcome;
    }
    Outcome<Done> add(run::FinishedCycle finished, std::span<const run::CycleRow> rows) override {
        losses_ = losses_of(finished.cycle_run.run.mesh);
        return folders_.add(rows, std::filesystem::path(finished.files.view).filename().string());
    }
    Outcome<Done> deliver(int cycle) override;

    Outcome<run::SolverResult> solve(const run::SolverCall& call);
    [[nodiscard]] const std::vector<Notice>& losses() const { return losses_; }
    [[nodiscard]] Error error_with_files(Error error) const;
    [[nodiscard]] std::string output_summary() const;

  private:
    [[nodiscard]] std::vector<Notice> losses_of(const AnyMesh& mesh) const {
        const std::string& to = pipeline_.output.mesh;
        if (to.empty()) return {};
        const auto format = format_of_mesh(to, pipeline_.output.format, format_of_input(to));
        return format ? (*format)->losses(mesh) : std::vector<Notice>{};
    }

    Outcome<Done> read_solved(const run::CycleFiles& from, const Execution& execution) {
        auto mesh = read_mesh(from.mesh, pipeline_.input.flat, execution);
        if (!mesh) return fail(mesh.error());
        name_references(mesh->mesh, folders_.groups());
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
                "its output is in " + said};
    }

    Outcome<Done> deliver_mesh(const run::CycleFiles& stored, const std::string& to, const std::string& name) {
        if (to.empty()) return Done{};
        const Execution execution{.threads = pipeline_.threads};
        const auto format = format_of_mesh(to, name, format_of_input(to));
        if (!format) return fail(format.error());
        const bool is_plain_copy = name.empty() && same_ending(stored.mesh, to) && (*format)->shared_extension.empty();
        if (is_plain_copy && !((*format)->has_fields && solved_)) return copied(stored.mesh, to);
        if (solved_) return write_with_mesh(solved_->mesh, solved_->fields, **format, to, execution);
        auto mesh = read_mesh(stored.mesh, pipeline_.input.flat, execution);
        if (!mesh) return fail(mesh.error());
        name_references(mesh->mesh, folders_.groups());
        std::vector<Notice> notices;
        return write_with_mesh(*mesh, fields_at_nodes(*mesh, notices), **format, to, execution);
    }

    /// Format of the first mesh's file, for endings that several formats share.
    [[nodiscard]] std::string_view format_of_input(const std::string& to) const {
        const auto* const file = std::get_if<config::FilePath>(&pipeline_.input.source);
        const MeshFormat* const by_ending = format_with_extension(mesh_formats(), to);
        if (file == nullptr || by_ending == nullptr || by_ending->shared_extension.empty()) return {};
        const auto bytes = read_file(file->path);
        const MeshFormat* const format = bytes ? format_with_content(mesh_formats(), *bytes) : nullptr;
        return format != nullptr ? format->name : std::string_view();
    }

    const config::Pipeline& pipeline_;
    CycleFolders folders_;
    int cycle_ = 0;
    std::optional<Solved> solved_;  ///< of the last cycle that was computed or delivered
    std::vector<Notice> losses_;
};

Outcome<run::SolverResult> CyclesInFolders::solve(const run::SolverCall& call) {
    const run::CycleFiles& into = call.files;
    const auto words = run::solver_command(pipeline_.adapt, call.cycle, into);
    const Execution execution{.threads = pipeline_.threads, .stop = stop_on_signals()};
    const auto ended = run_command_line(words, pipeline_.adapt.timeout, into.said, execution);
    if (!ended) return fail(ended.error());
    if (ended->end != CommandEnd::done) return fail(failed(*ended, words, into.said, call.cycle));
    std::error_code none;
    if (!std::filesystem::exists(into.solution, none))
        return fail(ErrorKind::input, fmt::format("was not written by the solver of cycle {}", call.cycle),
                    into.solution, {}, "see its output in " + into.said);
    if (auto read = read_solved(into, execution); !read) return fail(read.error());
    if (auto done = write_nodal_fields(solved_->mesh, solved_->fields, into.view, {}, execution); !done)
        return fail(done.error());
    return run::SolverResult{solved_->mesh.mesh, solved_->fields, ended->seconds};
}

Outcome<Done> CyclesInFolders::deliver(int cycle) {
    const config::Output& output = pipeline_.output;
    const run::CycleFiles stored = files(cycle);
    if (!pipeline_.adapt.solve.empty() && cycle != cycle_)
        if (auto read = read_solved(stored, {.threads = pipeline_.threads}); !read) return read;
    if (auto done = deliver_mesh(stored, output.mesh, output.format); !done) return done;
    std::vector<std::array<std::string, 2>> pairs{{stored.report, output.report},
                                                  {stored.vtu, output.vtu},
                                                  {stored.metric, output.metric},
                                                  {stored.page, output.page}};
    if (!output.plots.empty()) {
        if (auto folder = make_folder(output.plots); !folder) return folder;
        const auto from = plot_files(stored.plots), to = plot_files(output.plots);
        for (std::size_t i = 0; i < from.size(); ++i) pairs.push_back({from[i], to[i]});
    }
    if (!solved_) pairs.push_back({stored.carried, output.solution});
    for (const auto& [from, to] : pairs) {
        std::error_code none;
        if (from.empty() || to.empty() || !std::filesystem::exists(from, none)) continue;
        if (auto done = copied(from, to); !done) return done;
    }
    if (!solved_ || output.solution.empty()) return Done{};
    return write_nodal_fields(solved_->mesh, solved_->fields, output.solution, {}, {.threads = pipeline_.threads});
}

Error CyclesInFolders::error_with_files(Error error) const {
    if (folders_.rows().empty() || !folders_.is_permanent()) return error;
    const int last = folders_.rows().back().cycle;
    error.what +=
        fmt::format("; cycles 0 to {} are complete in {}; continue with --from {}", last, folders_.path(), last);
    return error;
}

std::string CyclesInFolders::output_summary() const {
    const config::Output& output = pipeline_.output;
    std::string text =
        wrote_rows({output.mesh, output.vtu, output.metric, output.solution, output.report, output.plots, output.page});
    if (folders_.is_permanent()) text += "  wrote " + folders_.path() + "/series.pvd and cycles.json next to it\n";
    return text;
}

class Printed {
  public:
    explicit Printed(const config::Adaptation& adapt) : adapt_(adapt) { say(run::cycles_head(adapt)); }

    void row(const run::CycleRow& row) { say(run::cycles_line(row, adapt_)); }
    void notice(const Notice& notice) {
        if (reported_notices_.insert(notice.what).second) print_notice(notice);
    }
    Outcome<Done> finish() {
        auto said = out_.finish();
        if (!said) failed_ = said.error();
        return said;
    }
    /// Error of standard output, if that ended the cycles.
    [[nodiscard]] const std::optional<Error>& failed() const { return failed_; }

    Outcome<int> end(const run::EndedCycles& ended, const CyclesInFolders& store) {
        int code = ended.is_valid() ? 0 : 1;
        if (!ended.is_valid())
            print_line(ended.reason + (ended.rows.size() == 1
                                           ? ": repair it first (camber repair)"
                                           : ": the cycles end there, and the outputs are those of the previous mesh"));
        for (const Notice& loss : store.losses()) notice(loss);
        for (const std::string& note : ended.notes) print_note(note);
        if (ended.is_valid())
            for (const std::string& miss : ended.rows[ended.result].misses) {
                print_line(miss);
                code = 1;
            }
        const bool is_early = ended.is_valid() && !ended.reason.empty();
        say("\n" + (is_early ? "  " + ended.reason + "\n" : std::string()) + store.output_summary());
        return finish().map([&](Done) { return code; });
    }

  private:
    void say(std::string_view text) {
        if (prints_notes()) out_.print(text);
    }

    const config::Adaptation& adapt_;
    StandardOutput out_;
    std::optional<Error> failed_;
    std::set<std::string> reported_notices_;
};

std::string cycles_folder_of(const config::Pipeline& pipeline) {
    if (!pipeline.adapt.folder.empty()) return pipeline.adapt.folder;
    if (pipeline.adapt.solve.empty() && !pipeline.output.mesh.empty()) return {};
    if (pipeline.output.mesh.empty()) return "camber.cycles";
    return std::filesystem::path(pipeline.output.mesh).replace_extension(".cycles").string();
}

Outcome<CycleFolders> folders_of(const config::Pipeline& pipeline, const CyclesChoice& choice) {
    const std::string cycles_folder = cycles_folder_of(pipeline);
    if (cycles_folder.empty() && choice.from)
        return fail(ErrorKind::usage, "there are no cycles to continue: they are not stored", "--from", {},
                    "give --folder");
    if (choice.from && *choice.from >= pipeline.adapt.cycles)
        return fail(ErrorKind::usage,
                    fmt::format("no cycles remain after cycle {} of {}", *choice.from, pipeline.adapt.cycles), "--from",
                    {}, "increase the number of cycles");
    if (cycles_folder.empty()) return CycleFolders::passing(pipeline.output.mesh);
    return choice.from ? CycleFolders::continued(cycles_folder, *choice.from) : CycleFolders::anew(cycles_folder);
}

Outcome<int> run_cycles(const config::Pipeline& pipeline, const CyclesChoice& choice) {
    if (auto possible = run::check_cycles(pipeline); !possible) return fail(possible.error());
    if (auto possible = check_outputs(pipeline.output); !possible) return fail(possible.error());
    auto folders = folders_of(pipeline, choice);
    if (!folders) return fail(folders.error());
    CyclesInFolders store(pipeline, std::move(*folders));
    Printed printed(pipeline.adapt);
    for (const run::CycleRow& row : store.rows()) printed.row(row);
    const auto solve = [&](const run::SolverCall& call) { return store.solve(call); };
    run::CycleListener listener;
    listener.on_mesh = [&](const run::Run& run) {
        for (const std::string& notice : run.report.notices)
            printed.notice({notice, std::ranges::find(run.details, notice) != run.details.end()});
    };
    listener.row_added = [&](const run::CycleRow& row) {
        printed.row(row);
        return printed.finish();
    };
    const Execution execution{.threads = pipeline.threads, .stop = stop_on_signals()};
    const auto ended = run::adapt(pipeline, store, pipeline.adapt.solve.empty() ? run::CycleSolver() : solve, listener,
                                  required_by(choice), without_wrapper(execution));
    if (ended) return printed.end(*ended, store);
    return fail(printed.failed() ? *printed.failed() : store.error_with_files(ended.error()));
}

Outcome<std::string> plan_cycles(const config::Pipeline& pipeline, const CyclesChoice& choice) {
    if (auto possible = run::check_cycles(pipeline); !possible) return fail(possible.error());
    config::Pipeline once = pipeline;
    once.adapt = {};
    // The solution is not known yet. The plan describes the run of the first mesh.
    if (!pipeline.adapt.solve.empty()) once = run::first_pipeline(pipeline, run::files_of_cycle(pipeline, ""));
    once.output = pipeline.output;
    auto text = plan(once, run::fit_of_cycle(1, required_by(choice)));
    if (!text) return text;
    const std::string cycles_folder = cycles_folder_of(pipeline);
    *text += fmt::format("  at most {} such cycles{}{}\n", pipeline.adapt.cycles,
                         pipeline.adapt.solve.empty() ? "" : ", each after the solver",
                         cycles_folder.empty() ? "" : "; stored in " + cycles_folder);
    return text;
}

}  // namespace

Outcome<int> run_or_plan_cycles(const config::Pipeline& pipeline, const std::vector<NamedFile>& files,
                                const CyclesChoice& choice, bool dry_run) {
    // Each cycle overwrites the output mesh. An input at the same path would be lost while later cycles need it.
    std::vector<NamedFile> named = files;
    for (NamedFile& file : named) {
        if (file.role == Role::input_mesh) file.role = Role::input;
        if (file.path == standard_stream)
            return fail(ErrorKind::usage, "cycles read and write their files repeatedly, which streams do not support",
                        file.word + " -", {}, "give a file");
    }
    if (auto distinct = check_named_files(named); !distinct) return fail(distinct.error());
    if (!dry_run) return run_cycles(pipeline, choice);
    return plan_cycles(pipeline, choice).map([](const std::string& text) {
        return end_with(text + "\n  nothing was done\n");
    });
}

}  // namespace camber::app
