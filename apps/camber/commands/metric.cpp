module;
#include <algorithm>
#include <cstddef>
#include <exception>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.bezier;
import camber.config;
import camber.io;
import camber.metric;
import camber.recipes;
import camber.run;
import camber.solution_metric;
import camber.transfer;
import :ending;
import :execute;
import :formats;
import :named_files;
import :nodal_fields;

namespace camber::app {

namespace {

/// "3=0.01": facets of reference 3; "2:3=0.01" says the dimension.
Outcome<ReferenceSize> size_of(const std::string& text, int dimension) {
    ReferenceSize out{.dimension = dimension - 1};
    const auto refuse = [&] {
        return fail(ErrorKind::usage, "is no size by reference", "--size " + text, {},
                    "write REFERENCE=SIZE, as 3=0.01, or DIMENSION:REFERENCE=SIZE");
    };
    const auto equals = text.find('='), colon = text.find(':');
    if (equals == std::string::npos) return refuse();
    const std::size_t begin = colon < equals ? colon + 1 : 0;
    try {
        std::size_t used = 0;
        if (begin > 0) out.dimension = std::stoi(text.substr(0, colon));
        out.reference = static_cast<Reference>(std::stol(text.substr(begin, equals - begin)));
        out.size = std::stod(text.substr(equals + 1), &used);
        if (used != text.size() - equals - 1) return refuse();
    } catch (const std::exception&) {
        return refuse();
    }
    return out;
}

/// Each component of each field is a function by itself.
std::vector<Column<double>> scalars_of(const std::vector<NamedField>& fields) {
    std::vector<Column<double>> scalars;
    for (const NamedField& field : fields) {
        const auto width = static_cast<std::size_t>(field.field.components);
        for (std::size_t c = 0; c < width; ++c) {
            if (width == 1) {
                scalars.push_back(field.field.values);
                continue;
            }
            Buffer<double> values(field.field.values.size() / width, 0.0);
            for (std::size_t n = 0; n < values.size(); ++n) values[n] = field.field.values[n * width + c];
            scalars.emplace_back(std::move(values));
        }
    }
    return scalars;
}

/// At the vertices of a straight mesh, at all nodes of a curved one.
template <int D>
Outcome<NamedField> as_field(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& logs, bool at_nodes,
                             const Execution& execution) {
    Column<LogMetric<D>> all = logs;
    if (at_nodes) {
        const auto nodal = framed_logs(mesh.edges, logs, execution);
        if (!nodal) return fail(nodal.error());
        Buffer<LogMetric<D>> joined(nodal->vertices.begin(), nodal->vertices.end());
        joined.insert(joined.end(), nodal->mid_nodes.begin(), nodal->mid_nodes.end());
        all = Column<LogMetric<D>>(std::move(joined));
    }
    Buffer<double> values;
    values.reserve(all.size() * sym_size<D>);
    for (const LogMetric<D>& log_metric : all) {
        const Sym<D> tensor = exp(log_metric).m;
        values.insert(values.end(), tensor.c.begin(), tensor.c.end());
    }
    return NamedField{
        "metric", FieldKind::symmetric_tensor, {sym_size<D>, at_nodes ? 2 : 1, Column<double>(std::move(values))}};
}

template <int D>
std::string told(const MetricOfSolution<D>& made, const MetricOfSolutionOptions& options, const std::string& largest) {
    const SolutionMetric<D>& m = made.metric;
    std::string text = result_row("complexity asked", fmt::format("{:.6g}", m.asked));
    text += result_row("complexity",
                       fmt::format("{:.6g} ({} evaluations, {} gradations)", m.reached, m.evaluations, m.gradations));
    text += result_row("elements expected", fmt::format("{:.0f}", m.reached * elements_per_complexity<D>()));
    if (m.of_fixed > 0) text += result_row("of what is fixed", fmt::format("{:.6g}", m.of_fixed));
    text += result_row("largest anisotropy", largest);
    text += result_row("vertices at bounds", fmt::format("{:.1f} % at the smallest size, {:.1f} % at the largest",
                                                         100 * m.at_min, 100 * m.at_max));
    text += result_row("derivatives", fmt::format("{} rows: {} of the boundary from inner ones, {} of a lower degree",
                                                  made.rows, made.from_inner_fits, made.lower_degree));
    text += result_row("models", fmt::format("degree {}; {} without derivatives, {} bounded to an anisotropy of {:.3g}",
                                             options.norm.degree, made.zero_models, made.floored_models,
                                             options.models.max_anisotropy));
    return text;
}

void say_shortfall(const auto& metric) {
    if (metric.is_fixed_alone)
        tell(
            fmt::format("note: sizes by reference, chords, bounds and gradation alone have the complexity {:.6g}: the "
                        "solution has no say (ask for more, or for less of them)",
                        metric.of_fixed));
    else if (!metric.is_reached)
        tell("note: the complexity is another than was asked for: bounds or gradation stand in the way");
    if (!metric.is_graded) tell("note: the gradation ended before its time: somewhere sizes still grow faster");
}

template <int D>
Outcome<std::string> made_metric(const MetricArguments& a, const DecodedMesh& decoded,
                                 const std::vector<NamedField>& fields, const Around& around) {
    const Execution quiet{.threads = a.threads, .stop = stop_on_signals()};
    auto mesh = of_degree_2<D>(decoded, quiet);
    if (!mesh) return fail(mesh.error());
    MetricOfSolutionOptions options = a.options;
    const bool at_nodes = fields.front().field.degree == 2;
    for (const NamedField& field : fields)
        if ((field.field.degree == 2) != at_nodes)
            return fail(ErrorKind::usage, "some fields are known at the vertices only", "--fields", {},
                        "name those that are known alike");
    options.models.max_anisotropy = std::max(options.models.max_anisotropy, options.metric.max_anisotropy);
    options.norm.degree = a.degree.value_or(at_nodes ? 2 : 1);
    for (const std::string& text : a.sizes) {
        auto size = size_of(text, D);
        if (!size) return fail(size.error());
        options.sizes.push_back(*size);
    }
    const auto scalars = scalars_of(fields);
    const auto made = metric_of_solution<D>(*mesh, scalars, options, around);
    if (!made) return fail(made.error());
    const auto largest = largest_anisotropy(made->metric.log_metrics, quiet);
    if (!largest) return fail(largest.error());
    const bool is_curved = std::holds_alternative<QuadraticMesh<D>>(decoded.mesh);
    auto field = as_field(*mesh, made->metric.log_metrics, is_curved, quiet);
    if (!field) return fail(field.error());
    auto written = write_nodal_fields(decoded, {*field}, a.output, quiet);
    if (!written) return fail(written.error());
    say_shortfall(made->metric);
    return told(*made, options, fmt::format("{:.4g}", *largest));
}

Outcome<std::string> metric_text(const MetricArguments& a) {
    const std::vector<NamedFile> files{
        {a.input, "the input", Role::input}, {a.solution, "--solution", Role::input}, {a.output, "-o", Role::output}};
    if (auto distinct = check_named_files(files); !distinct) return fail(distinct.error());
    if (auto ending = check_fields_ending(a.output); !ending) return fail(ending.error());
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = a.threads, .stop = stop});
    auto decoded = run_step(around, "read", [&](const Execution& e) { return read_mesh(a.input, a.flat, e); });
    if (!decoded) return fail(decoded.error());
    std::vector<Notice> notices = decoded->notices;
    const auto fields = run_step(around, "read solution", [&](const Execution& e) {
        return read_nodal_fields(*decoded, a.solution, a.fields, notices, e);
    });
    if (!fields) return fail(fields.error());
    for (const Notice& notice : notices) tell("note: " + notice.what);
    auto text = run::plan_size(decoded->mesh).dimension == 2 ? made_metric<2>(a, *decoded, *fields, around)
                                                             : made_metric<3>(a, *decoded, *fields, around);
    progress.wipe();
    if (!text) return fail(of_file(text.error(), a.input));
    return a.input + "\n" + *text + fmt::format("wrote {}\n", a.output);
}

}  // namespace

int metric_command(const MetricArguments& arguments) {
    const auto text = metric_text(arguments);
    if (!text) return report_error(text.error());
    return end_with(*text);
}

}  // namespace camber::app
