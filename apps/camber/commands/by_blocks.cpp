module;
#include <algorithm>
#include <cstddef>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.ordering;
import camber.io;
import camber.distributed;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

/// Approximate memory for each element of a part that is in progress (bytes). A quarter of the memory limit is for it.
constexpr double bytes_of_element = 500;

bool is_meshb(const std::string& path) { return path.ends_with(".meshb"); }

bool is_written_by_rows(const config::Output& output) {
    return is_meshb(output.mesh) && output.format.empty() && output.partition == 0;
}
bool is_written_by_pieces(const config::Output& output) {
    return names_its_pieces(output.mesh) && output.format.empty() && output.partition > 0;
}

class BlocksRun {
  public:
    BlocksRun(const config::Pipeline& pipeline, Written& written, Host host)
        : pipeline_(pipeline), written_(written), host_(std::move(host)), steps_(pipeline, host_) {
        sources_.ranks = host_.ranks;
        if (const auto requested = run::requested_blocks(pipeline)) requested_ = *requested;
        if (requested_.blocks > 0) sources_.blocks.elements = static_cast<std::size_t>(requested_.blocks);
    }

    Outcome<run::Run> run() {
        return together(*host_.ranks, [&] { return run_on_rank(); });
    }

  private:
    Outcome<run::Run> run_on_rank() {
        release_freed_memory();
        if (auto bounded = limit_memory(); !bounded) return fail(bounded.error());
        if (auto outputs = check_own_outputs(); !outputs) return fail(outputs.error());
        const auto* const file = std::get_if<config::FilePath>(&pipeline_.input.source);
        if (file != nullptr && is_meshb(file->path) && is_mapped()) return run_mapped(file->path);
        return run_in_memory();
    }

    /// True if several ranks read the input by offsets, or one rank does because it may exceed the memory limit.
    [[nodiscard]] bool is_mapped() const {
        return host_.ranks->size() > 1 || (requested_.memory > 0 && is_written_by_rows(pipeline_.output));
    }

    /// Stores new arrays in files next to the output. From half of the memory limit, inactive data leaves memory.
    Outcome<Done> limit_memory() {
        const double bound = requested_.memory;
        if (!(bound > 0)) return Done{};
        const std::filesystem::path beside = std::filesystem::path(pipeline_.output.mesh).parent_path();
        const std::string folder = beside.empty() ? "." : beside.string();
        if (const int error = store_arrays_in_files(folder); error != 0)
            return fail(ErrorKind::write,
                        "arrays cannot be stored in files there: " + std::generic_category().message(error), folder, {},
                        "write the mesh to a local disk, or leave out --memory");
        sources_.blocks.elements_at_once = static_cast<std::size_t>(bound / (4 * bytes_of_element));
        sources_.blocks.memory.before = [] { (void)store_arrays_in_files(""); };
        sources_.blocks.memory.after = [folder] { (void)store_arrays_in_files(folder); };
        sources_.blocks.memory.leave = [bound] {
            if (static_cast<double>(resident_bytes()) > bound / 2) release_array_memory();
        };
        return Done{};
    }

    Outcome<Done> check_own_outputs() const {
        const config::Output& output = pipeline_.output;
        for (const std::string& other : {output.vtu, output.metric, output.solution, output.plots, output.page})
            if (!other.empty())
                return fail(ErrorKind::unsupported, "cannot be written by blocks", other, {},
                            "write only the mesh and the report, and create other files from the mesh");
        if (host_.ranks->size() > 1 && !is_written_by_rows(output) && !is_written_by_pieces(output))
            return fail(ErrorKind::unsupported, "several ranks can only write .meshb, or .pvtu in parts (--partition)",
                        output.mesh, {}, "convert it to other formats with camber convert");
        return host_.ranks->rank() == 0 ? check_outputs(output) : Done{};
    }

    Outcome<run::Run> run_mapped(const std::string& path) {
        auto in_space = mapped<3>(path);
        if (in_space) return run_on(std::move(*in_space));
        if (in_space.error().kind != ErrorKind::unsupported) return fail(in_space.error());
        auto plane = mapped<2>(path);
        if (!plane) return fail(in_space.error());
        return run_on(std::move(*plane));
    }

    Outcome<run::Run> run_in_memory() {
        const auto* const file = std::get_if<config::FilePath>(&pipeline_.input.source);
        auto decoded = run_step(steps_.around(), file != nullptr ? "read" : "generate", [&](const Execution& e) {
            return file != nullptr ? read_mesh(file->path, pipeline_.input.flat, e)
                                   : run::generate_shape(std::get<config::Shape>(pipeline_.input.source), e);
        });
        if (!decoded) return fail(decoded.error());
        return std::visit(
            [&]<int D>(Mesh<D> mesh) -> Outcome<run::Run> {
                if (mesh.degree > 1)
                    return fail(ErrorKind::unsupported, "the mesh is curved; blocks require a straight mesh", {}, {},
                                "use camber convert --straighten");
                auto opened = run_step(steps_.around(), "prepare",
                                       [&](const Execution& e) { return prepared<D>(std::move(mesh), notices_, e); });
                if (!opened) return fail(opened.error());
                opened->lift = decoded->lift;
                return run_on(std::move(*opened));
            },
            std::move(decoded->mesh));
    }

    /// Rows of a metric file belong to the vertices in the order of the mesh file, which is the order of the mesh here.
    template <int D>
    Outcome<std::vector<run::MetricFile>> metric_files(const Opened<D>& opened, const Execution& execution) const {
        std::vector<std::string> paths;
        const auto add = [&](const config::Metric& metric) {
            if (const auto* file = std::get_if<config::FilePath>(&metric)) paths.push_back(file->path);
        };
        add(pipeline_.metric);
        for (const config::MetricOperation& operation : pipeline_.metric_operations)
            if (const auto* intersect = std::get_if<config::Intersect>(&operation)) add(intersect->metric);
        std::vector<run::MetricFile> files;
        for (const std::string& path : paths) {
            auto decoded = read_solution(path, execution);
            if (!decoded) return fail(decoded.error());
            if (decoded->solution.rows != opened.rows->counts().points)
                return fail(ErrorKind::input,
                            "has " + std::to_string(decoded->solution.rows) + " rows, the mesh " +
                                std::to_string(opened.rows->counts().points) + " vertices",
                            path);
            run::MetricFile file{path, std::move(decoded->solution)};
            if (opened.order) {
                auto values = renumbered_rows(file.solution.values, opened.order->renumbering.vertices.before,
                                              execution, file.solution.values.size() / file.solution.rows);
                if (!values) return fail(values.error());
                file.solution.values = std::move(*values);
            }
            files.push_back(std::move(file));
        }
        return files;
    }

    template <int D>
    Outcome<run::Run> run_on(Opened<D> opened) {
        const StepWrapper around = steps_.around();
        auto read = around("read", [&](const Execution& e) -> Outcome<Done> {
            auto metric = metric_files(opened, e);
            if (!metric) return fail(metric.error());
            sources_.files = std::move(*metric);
            auto model = read_geometry(pipeline_.geometry, e);
            if (!model) return fail(model.error());
            sources_.geometry = std::move(*model);
            return Done{};
        });
        if (!read) return fail(read.error());
        auto result = run::run_steps<D>(*opened.rows, pipeline_, sources_, around);
        if (!result) return fail(result.error());
        run::Run run{.mesh = Mesh<D>{}, .report = std::move(result->report), .fields = {}};
        std::ranges::copy(notices_, std::back_inserter(run.report.notices));
        if (opened.order) restore_numbers(run.report, opened.order->renumbering.vertices);
        if (!pipeline_.output.mesh.empty()) {
            auto done =
                written_.add(pipeline_.output.mesh,
                             around("write", [&](const Execution& e) { return write(opened, result->curved, e); }));
            if (!done) return fail(done.error());
        }
        if (auto done = add_costs(run.report); !done) return fail(done.error());
        const RowCounts counts = opened.rows->counts();
        steps_.add_to(run.report, origin_of(pipeline_, {.dimension = D,
                                                        .degree = 1,
                                                        .vertices = counts.points,
                                                        .elements = counts.elements,
                                                        .facets = counts.facets}));
        if (auto done = write_report(run.report, pipeline_.output, host_, written_); !done) return fail(done.error());
        return run;
    }

    static void restore_numbers(run::Report& report, const Permutation<VertexId>& order) {
        for (auto* const deviation : {&report.boundary->node_deviation, &report.boundary->vertex_deviation})
            for (std::size_t& v : (*deviation)->vertices)
                if (v != 0) v = order.before[VertexId(v - 1)].index() + 1;
    }

    Outcome<Done> add_costs(run::Report& report) {
        struct Cost {
            std::size_t peak = 0, sent = 0;
            double seconds = 0;
        };
        const Traffic traffic = host_.ranks->traffic();
        const Cost own{Meter().read().peak_bytes, traffic.bytes,
                       static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC)};
        const auto all = gather_all(*host_.ranks, Outcome<std::vector<Cost>>({own}));
        if (!all) return fail(all.error());
        run::RanksReport& ranks = report.ranks.emplace();
        ranks.number = host_.ranks->size();
        ranks.rounds = traffic.rounds;
        for (const Cost& cost : *all) {
            ranks.peak_bytes.push_back(cost.peak);
            ranks.processor_seconds.push_back(cost.seconds);
            ranks.sent_bytes.push_back(cost.sent);
        }
        return Done{};
    }

    template <int D>
    Outcome<Done> write(const Opened<D>& opened, const CurvedBlocks<D>& curved, const Execution& execution) {
        const config::Output& output = pipeline_.output;
        const bool is_unchanged = !opened.order && !opened.lift;
        if (host_.ranks->size() > 1 && !is_unchanged)
            return fail(ErrorKind::unsupported,
                        opened.lift ? "several ranks cannot write a flat mesh in space"
                                    : "several ranks cannot reorder a mesh, and this one has an unsuitable order",
                        output.mesh, {}, "use one process, which reorders and writes it");
        if (host_.ranks->size() > 1 && is_written_by_pieces(output)) return write_pieces(opened, curved, execution);
        if (is_written_by_rows(output) && is_unchanged) return write_parts(opened, curved, execution);
        const auto format = output.partition > 0 ? format_of_parts(output.mesh, output.format)
                                                 : format_of_mesh(output.mesh, output.format);
        if (!format) return fail(format.error());
        auto mesh = joined(curved, *opened.mesh, execution);
        if (!mesh) return fail(mesh.error());
        if (opened.order) {
            auto original = renumbered(std::move(*mesh), inverse(opened.order->renumbering), execution);
            if (!original) return fail(original.error());
            *mesh = std::move(original->mesh);
        }
        AnyMesh whole(as_mesh(std::move(*mesh)));
        if (opened.lift && (*format)->is_always_3d) {
            auto in_space = raised(whole, *opened.lift, execution);
            if (!in_space) return fail(in_space.error());
            whole = std::move(*in_space);
        }
        const EncodeOptions options{output.vtu_cells};
        if (output.partition > 0)
            return write_in_parts(**format, {whole, {}},
                                  {output.mesh, static_cast<std::size_t>(output.partition), options}, written_,
                                  execution);
        return write_mesh(**format, whole, {}, options, output.mesh, execution);
    }

    /// Each rank writes some of the pieces, whose data is on all ranks.
    template <int D>
    Outcome<Done> write_pieces(const Opened<D>& opened, const CurvedBlocks<D>& curved, const Execution& execution) {
        Ranks& ranks = *host_.ranks;
        const auto parts = static_cast<std::size_t>(pipeline_.output.partition);
        const auto own = parts_of_blocks<D>(*opened.rows, curved, parts, host_.partition, ranks, execution);
        if (!own) return fail(own.error());
        return write_parts_of_ranks(ranks, opened.rows->counts(), *own,
                                    {pipeline_.output.mesh, parts, {pipeline_.output.vtu_cells}}, execution)
            .map([](const auto&) { return Done{}; });
    }

    template <int D>
    Outcome<Done> write_parts(const Opened<D>& opened, const CurvedBlocks<D>& curved, const Execution& execution) {
        Ranks& ranks = *host_.ranks;
        const auto parts = QuadraticParts<D>::make(*opened.rows, curved, ranks);
        if (!parts) return fail(parts.error());
        const auto lists = opened.rows->lists();
        if (!lists) return fail(lists.error());
        return write_meshb_together<D, 2>(
            ranks, pipeline_.output.mesh, {parts->totals(), *lists}, parts->pieces(),
            [&](std::size_t turn) { return parts->piece(turn); }, execution);
    }

    const config::Pipeline& pipeline_;
    Written& written_;
    Host host_;
    TimedSteps steps_;
    CurveByBlocks requested_ = {};
    run::BlockSources sources_ = {};
    std::vector<std::string> notices_;
};

}  // namespace

bool runs_by_blocks(const config::Pipeline& pipeline, const Host& host) {
    if (run::requested_blocks(pipeline)) return true;
    if (host.ranks->size() == 1) return false;
    return std::ranges::any_of(pipeline.stages,
                               [](const config::Stage& s) { return std::holds_alternative<config::Curve>(s); });
}

Outcome<run::Run> execute_by_blocks(const config::Pipeline& pipeline, Written& written, Host host) {
    auto run = BlocksRun(pipeline, written, std::move(host)).run();
    if (!run) return fail(of_input(run.error(), pipeline));
    return run;
}

}  // namespace camber::app
