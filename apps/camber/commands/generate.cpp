module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.io;
import camber.shapes;
import camber.distributed;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

bool names_file(std::string_view text) {
    return text.find_first_of("{\"") == std::string_view::npos && text.find_first_of("./\\") != std::string_view::npos;
}

Outcome<config::Shape> read_shape(const GenerateArguments& a) {
    if (!names_file(a.shape)) return config::read_shape(a.shape, "shape", a.settings);
    auto bytes = read_file(a.shape);
    if (!bytes) return fail(std::move(bytes.error()));
    return config::read_shape(as_text(*bytes), a.shape, a.settings);
}

Outcome<config::Shape> with_structure(config::Shape shape, ShellStructure structure) {
    const bool has = std::visit(
        [&](auto& options) {
            if constexpr (requires { options.structure; }) {
                options.structure = structure;
                return true;
            }
            return false;
        },
        shape);
    if (has) return shape;
    return fail(ErrorKind::usage, "--structure is for shell and annulus", config::name_of(shape), {}, "leave it out");
}

double expected(const config::Shape& shape) {
    return std::visit([](const auto& options) { return expected_elements(options); }, shape);
}

std::string count_text(double elements) { return fmt::format("{:.8g}", std::round(elements)); }

/// Returns the shape with approximately this number of elements. Errors: usage (its layers alone have twice as many).
Outcome<config::Shape> with_count(const config::Shape& shape, double elements) {
    config::Shape scaled =
        std::visit([&](const auto& options) { return config::Shape(with_elements(options, elements)); }, shape);
    const double nearest = expected(scaled);
    const auto off_by = [&](double factor) { return nearest > factor * elements || nearest < elements / factor; };
    const std::string what =
        "is available in steps: " + count_text(nearest) + " elements are closest to " + count_text(elements);
    if (off_by(2))
        return fail(ErrorKind::usage, what, config::name_of(shape), {}, "increase --elements, or use fewer layers");
    if (off_by(1.2)) print_note(config::name_of(shape) + " " + what);
    return scaled;
}

bool is_unstructured(const config::Shape& shape) {
    return std::visit(
        [](const auto& options) {
            if constexpr (requires { options.structure; }) return options.structure == ShellStructure::unstructured;
            return false;
        },
        shape);
}

double needed_memory(const config::Shape& shape) {
    // Peaks for 10^6 elements were below this in all formats. Per element: 30 to 90 bytes for prisms and lattices, 210
    // for Delaunay.
    constexpr double program = 1e7;
    return program + (is_unstructured(shape) ? 220 : 100) * expected(shape);
}

Outcome<Done> check_memory(const config::Shape& shape) {
    if (!(expected(shape) < static_cast<double>(max_entities))) return Done{};  // the generator reports this error
    const double needed = needed_memory(shape);
    const MemoryLimit limit = memory_limit();
    if (!(needed > static_cast<double>(limit.bytes))) return Done{};
    return fail(ErrorKind::memory,
                fmt::format("{} elements need about {} of memory, and {} gives {}", count_text(expected(shape)),
                            readable(static_cast<std::size_t>(needed)), limit.source, readable(limit.bytes)),
                config::name_of(shape), {}, "provide more memory, or reduce --elements");
}

void warn_of_time(const config::Shape& shape) {
    constexpr double per_second = 65000, noticed = 60;
    const double seconds = expected(shape) / per_second;
    if (is_unstructured(shape) && seconds > noticed)
        print_note(
            fmt::format("--structure unstructured takes about {:.0f} s for {} elements; --structure prisms "
                        "takes a few seconds",
                        seconds, count_text(expected(shape))));
}

config::Pipeline pipeline_of_shape(const config::Shape& shape, const GenerateArguments& a) {
    config::Pipeline pipeline;
    pipeline.input.source = shape;
    pipeline.stages = {};
    pipeline.threads = a.threads;
    pipeline.output.mesh = a.output;
    pipeline.output.format = a.format;
    return pipeline;
}

Outcome<Done> check_names(const GenerateArguments& a) {
    return check_named_files({{names_file(a.shape) ? a.shape : std::string(), "the config", Role::input},
                              {a.output, "-o", Role::output_mesh}});
}

std::string text_of(const run::PlanSize& size, const config::Shape& shape) {
    const bool flat = size.dimension == 2;
    return fmt::format("{}: {} {}, {} vertices, {} boundary {}\n", config::name_of(shape), size.elements,
                       flat ? "triangles" : "tetrahedra", size.vertices, size.facets, flat ? "edges" : "triangles");
}

Outcome<std::string> generate_and_write(const config::Shape& shape, const MeshFormat& format,
                                        const GenerateArguments& a, Written& written) {
    Progress progress;
    const Execution execution{.threads = a.threads, .stop = stop_on_signals(), .progress = progress.ticks()};
    progress.begin("generate");
    const Meter generating;
    const auto mesh = run::generate_shape(shape, execution);
    if (!mesh) return fail(mesh.error());
    const Usage generated = generating.read();
    progress.begin("write");
    const Meter writing;
    auto done = written.add(a.output, write_mesh(format, mesh->mesh, {}, EncodeOptions{}, a.output, execution));
    if (!done) return fail(std::move(done.error()));
    progress.wipe();
    for (const Notice& notice : format.losses(mesh->mesh)) print_notice(notice);
    std::string text = text_of(run::plan_size(mesh->mesh), shape);
    text += fmt::format("  generated in {:.2f} s", generated.seconds);
    if (generated.peak_bytes > 0) text += fmt::format(" (at most {})", readable(generated.peak_bytes));
    return text + fmt::format(", written in {:.2f} s\n", writing.read().seconds) + wrote_rows({a.output});
}

/// Approximate number of elements generated at a time; at least a few rows, since each time repeats adjacent points.
constexpr std::size_t elements_of_turn = std::size_t{1} << 20U, least_rows_of_turn = 3;

template <class Options>
constexpr int dimension_of = 0;
template <int D>
constexpr int dimension_of<BoxOptions<D>> = D;
template <int D>
constexpr int dimension_of<ShellOptions<D>> = D;

template <int K>
SimplexRun<K, 1> simplex_run(std::size_t first, const auto& simplices, Buffer<Reference> references) {
    SimplexRun<K, 1> run{first, {}, std::move(references)};
    run.nodes.reserve(simplices.size());
    for (const SimplexVertices<K>& simplex : simplices) {
        auto& nodes = run.nodes.emplace_back();
        for (std::size_t v = 0; v <= K; ++v) nodes[v] = simplex[v].value;
    }
    return run;
}

template <int D>
FilePart<D, 1> file_part(ShapeRun<D> run) {
    FilePart<D, 1> part;
    part.vertices = {run.first_vertex, std::move(run.points), std::move(run.point_references)};
    part.elements = simplex_run<D>(run.first_element, run.elements, std::move(run.materials));
    part.facets = simplex_run<D - 1>(run.first_facet, run.facets, std::move(run.facet_references));
    return part;
}

template <int D>
class OwnRows {
  public:
    OwnRows(const ShapeRows<D>& shape, const LinearMesh<D>& lists, const Ranks& ranks)
        : shape_(shape), lists_(lists), is_first_(ranks.rank() == 0) {
        const std::size_t rows = shape.rows(), n = ranks.size();
        begin_ = rows * ranks.rank() / n;
        end_ = rows * (ranks.rank() + 1) / n;
        const std::size_t most = (rows + n - 1) / n, of_row = shape.counts().elements / rows;
        const std::size_t in_turn = std::max(least_rows_of_turn, elements_of_turn / of_row);
        turns_ = (most + in_turn - 1) / in_turn;
    }

    /// The same number on each rank.
    [[nodiscard]] std::size_t turns() const { return turns_; }
    /// The edges, which are few, are written with the first rows.
    [[nodiscard]] Outcome<FilePart<D, 1>> part(std::size_t turn, const Execution& execution) const {
        const std::size_t own = end_ - begin_;
        auto run = shape_.run(begin_ + own * turn / turns_, begin_ + own * (turn + 1) / turns_, execution);
        if (!run) return fail(run.error());
        FilePart<D, 1> part = file_part<D>(std::move(*run));
        if constexpr (D == 3)
            if (turn == 0 && is_first_) {
                Buffer<Reference> references(lists_.edges.references.begin(), lists_.edges.references.end());
                part.edges = simplex_run<1>(0, lists_.edges.vertices, std::move(references));
            }
        return part;
    }

  private:
    const ShapeRows<D>& shape_;
    const LinearMesh<D>& lists_;
    bool is_first_;
    std::size_t begin_ = 0, end_ = 0, turns_ = 0;
};

template <int D>
Outcome<run::PlanSize> write_rows(Ranks& ranks, const ShapeRows<D>& shape, const std::string& path,
                                  const Execution& execution) {
    const auto lists = shape.lists();
    if (!lists) return fail(lists.error());
    const ShapeCounts counts = shape.counts();
    const PartTotals totals{
        .vertices = counts.vertices, .elements = counts.elements, .facets = counts.facets, .edges = counts.edges};
    const OwnRows<D> own(shape, *lists, ranks);
    const Execution quiet = without_progress(execution);
    auto done = write_meshb_together<D, 1>(
        ranks, path, {totals, *lists}, own.turns(), [&](std::size_t turn) { return own.part(turn, quiet); }, execution);
    if (!done) return fail(done.error());
    return run::PlanSize{
        .dimension = D, .degree = 1, .vertices = counts.vertices, .elements = counts.elements, .facets = counts.facets};
}

Outcome<Done> check_can_write_rows(const config::Shape& shape) {
    return std::visit(
        [&]<class Options>(const Options& options) -> Outcome<Done> {
            if constexpr (requires { options.structure; })
                if (options.structure == ShellStructure::prisms) return Done{};
            if constexpr (dimension_of<Options> > 0 && !requires { options.structure; }) return Done{};
            return fail(ErrorKind::unsupported, "is generated as a whole, so several ranks cannot share it",
                        config::name_of(shape), {},
                        "use --structure prisms of a shell or annulus, a box or a rectangle, or one rank");
        },
        shape);
}

/// Writes the mesh to a .meshb; each rank generates its rows, a few at a time. Returns the total size on all ranks.
Outcome<run::PlanSize> write_by_rows(Ranks& ranks, const config::Shape& shape, const std::string& path,
                                     const Execution& execution) {
    return std::visit(
        [&]<class Options>(const Options& options) -> Outcome<run::PlanSize> {
            if constexpr (dimension_of<Options> == 0)
                return fail(ErrorKind::internal, "a shape without rows");
            else {
                const auto rows = rows_of_shape(options, execution);
                if (!rows) return fail(rows.error());
                return write_rows<dimension_of<Options>>(ranks, **rows, path, execution);
            }
        },
        shape);
}

bool writes_rows(const MeshFormat& format) { return format.name == std::string_view("gmf-binary"); }

bool writes_by_rows(const config::Shape& shape, const MeshFormat& format, const Host& host) {
    if (host.ranks->size() > 1) return true;
    const auto limit = static_cast<double>(memory_limit().bytes);
    return needed_memory(shape) > limit && writes_rows(format) && check_can_write_rows(shape).has_value();
}

/// Largest memory peak of all ranks (bytes); 0: unknown on this system.
Outcome<std::size_t> largest_peak(Ranks& ranks) {
    const auto all = gather_all<std::size_t>(ranks, std::vector<std::size_t>{Meter().read().peak_bytes});
    if (!all) return fail(all.error());
    return std::ranges::max(*all);
}

Outcome<std::string> generate_by_rows(const config::Shape& shape, const MeshFormat& format, const GenerateArguments& a,
                                      const Host& host, Written& written) {
    Ranks& ranks = *host.ranks;
    if (!writes_rows(format))
        return fail(ErrorKind::unsupported, "several ranks can only write .meshb", a.output, {},
                    "convert it to other formats with camber convert");
    if (auto possible = check_can_write_rows(shape); !possible) return fail(possible.error());
    Progress progress;
    const Execution execution{.threads = a.threads, .stop = host.stop, .progress = progress.ticks()};
    progress.begin("generate");
    const Meter meter;
    const auto size = together(ranks, [&] { return write_by_rows(ranks, shape, a.output, execution); });
    if (auto done = written.add(a.output, size ? Outcome<Done>(Done{}) : fail(size.error())); !done)
        return fail(std::move(done.error()));
    progress.wipe();
    const auto peak = largest_peak(ranks);
    if (!peak) return fail(peak.error());
    std::string text = text_of(*size, shape) + fmt::format("  generated and written in {:.2f} s", meter.read().seconds);
    if (ranks.size() > 1) text += fmt::format(" by {} ranks", ranks.size());
    if (*peak > 0) text += fmt::format(" (at most {}{})", readable(*peak), ranks.size() > 1 ? " each" : "");
    return text + "\n" + wrote_rows({a.output});
}

}  // namespace

Outcome<config::Shape> shape_of(const GenerateArguments& a) {
    auto shape = read_shape(a);
    if (shape && a.structure) shape = with_structure(*shape, *a.structure);
    if (shape && a.elements) shape = with_count(*shape, *a.elements);
    return shape;
}

Outcome<DecodedMesh> generate_in_memory(const GenerateArguments& arguments, const Host& host) {
    const auto shape = shape_of(arguments);
    if (!shape) return fail(shape.error());
    if (auto enough = check_memory(*shape); !enough) return fail(enough.error());
    return ShownSteps(arguments.threads, host).run("generate", [&](const Execution& e) {
        return run::generate_shape(*shape, e);
    });
}

Outcome<int> generate_command(const GenerateArguments& arguments, const Host& host) {
    if (auto distinct = check_names(arguments); !distinct) return fail(distinct.error());
    const auto shape = shape_of(arguments);
    if (!shape) return fail(shape.error());
    if (arguments.print_config) return end_with(config::write_pipeline(pipeline_of_shape(*shape, arguments)));
    const auto format = format_of_mesh(arguments.output, arguments.format);
    if (!format) return fail(format.error());
    const bool by_rows = writes_by_rows(*shape, **format, host);
    if (!by_rows)
        if (auto enough = check_memory(*shape); !enough) return fail(enough.error());
    const bool writes_first = host.ranks->rank() == 0;
    const auto output = agreed(*host.ranks, writes_first ? check_writable(arguments.output) : Outcome<Done>(Done{}));
    if (!output) return fail(output.error());
    warn_of_time(*shape);
    Written written;
    const auto text = by_rows ? generate_by_rows(*shape, **format, arguments, host, written)
                              : generate_and_write(*shape, **format, arguments, written);
    if (!text) return fail(text.error());
    return end_with(*text, written);
}

}  // namespace camber::app
