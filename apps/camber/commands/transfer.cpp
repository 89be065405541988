module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import camber.transfer;
import :ending;
import :execute;
import :formats;
import :named_files;
import :nodal_fields;

namespace camber::app {

namespace {

std::string told(const TransferStatistics& s, const std::vector<NamedField>& fields, const TransferOptions& options) {
    std::string text = result_row("nodes kept", fmt::format("{}, to the bit", s.kept));
    text += result_row("nodes interpolated", std::to_string(s.interpolated));
    if (s.outside > 0)
        text += result_row("nodes outside", fmt::format("{}, by up to {:.3g}: the nearest point of the boundary",
                                                        s.outside, s.largest_distance));
    if (options.method == TransferMethod::conserve)
        text += result_row("projected", fmt::format("{} nodes of {} elements in {} patches", s.projected,
                                                    s.changed_elements, s.patches));
    if (options.method == TransferMethod::interpolate) return text;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        double change = 0, size = 0;
        for (const MaterialIntegrals& of : s.integrals[f])
            for (std::size_t c = 0; c < of.before.size(); ++c) {
                change = std::max(change, std::abs(of.after[c] - of.before[c]));
                size = std::max(size, std::abs(of.before[c]));
            }
        text += result_row("integral of " + fields[f].name, fmt::format("changed by {:.2g}, of {:.6g}", change, size));
    }
    return text;
}

template <int D>
Outcome<std::string> transferred(const TransferArguments& a, const DecodedMesh& old_mesh, const DecodedMesh& new_mesh,
                                 std::vector<NamedField> fields, const Around& around) {
    const Execution quiet{.threads = a.threads, .stop = stop_on_signals()};
    const auto from = of_degree_2<D>(old_mesh, quiet);
    if (!from) return fail(from.error());
    const auto to = of_degree_2<D>(new_mesh, quiet);
    if (!to) return fail(to.error());
    std::vector<TransferField> given;
    given.reserve(fields.size());
    for (const NamedField& field : fields) given.push_back(field.field);
    auto made =
        run_step(around, "transfer", [&](const Execution& e) { return transfer<D>(*from, given, *to, a.options, e); });
    if (!made) return fail(made.error());
    for (std::size_t f = 0; f < fields.size(); ++f) fields[f].field = std::move(made->fields[f]);
    auto written = run_step(around, "write",
                            [&](const Execution& e) { return write_nodal_fields(new_mesh, fields, a.output, e); });
    if (!written) return fail(written.error());
    return told(made->statistics, fields, a.options);
}

Outcome<std::string> transfer_text(const TransferArguments& a) {
    const std::vector<NamedFile> files{{a.old_mesh, "the old mesh", Role::input},
                                       {a.new_mesh, "the new mesh", Role::input},
                                       {a.solution, "--solution", Role::input},
                                       {a.output, "-o", Role::output}};
    if (auto distinct = check_named_files(files); !distinct) return fail(distinct.error());
    if (auto ending = check_fields_ending(a.output); !ending) return fail(ending.error());
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = a.threads, .stop = stop});
    auto from = run_step(around, "read", [&](const Execution& e) { return read_mesh(a.old_mesh, a.flat, e); });
    if (!from) return fail(from.error());
    auto to = run_step(around, "read", [&](const Execution& e) { return read_mesh(a.new_mesh, a.flat, e); });
    if (!to) return fail(to.error());
    const int dimension = run::plan_size(from->mesh).dimension;
    if (run::plan_size(to->mesh).dimension != dimension)
        return fail(ErrorKind::input, fmt::format("is not in {}D, as the old mesh is", dimension), a.new_mesh, {},
                    "give two meshes of one domain");
    std::vector<Notice> notices = from->notices;
    notices.insert(notices.end(), to->notices.begin(), to->notices.end());
    auto fields = run_step(around, "read solution", [&](const Execution& e) {
        return read_nodal_fields(*from, a.solution, a.fields, notices, e);
    });
    if (!fields) return fail(fields.error());
    for (const Notice& notice : notices) tell("note: " + notice.what);
    if (run::plan_size(to->mesh).degree == 1 &&
        std::ranges::any_of(*fields, [](const NamedField& f) { return f.field.degree == 2; }))
        tell("note: the new mesh is straight and of degree 1: the fields' values at its vertices are written");
    auto text = dimension == 2 ? transferred<2>(a, *from, *to, std::move(*fields), around)
                               : transferred<3>(a, *from, *to, std::move(*fields), around);
    progress.wipe();
    if (!text) return fail(of_file(text.error(), a.solution));
    return a.new_mesh + "\n" + *text + fmt::format("wrote {}\n", a.output);
}

}  // namespace

int transfer_command(const TransferArguments& arguments) {
    const auto text = transfer_text(arguments);
    if (!text) return report_error(text.error());
    return end_with(*text);
}

}  // namespace camber::app
