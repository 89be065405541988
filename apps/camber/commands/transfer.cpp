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

Outcome<std::string> transfer_text(const TransferArguments& a, Written& written) {
    const std::vector<NamedFile> files{{a.old_mesh, "the old mesh", Role::input},
                                       {a.new_mesh, "the new mesh", Role::input},
                                       {a.solution, "--solution", Role::input},
                                       {a.output, "-o", Role::output}};
    if (auto distinct = check_named_files(files); !distinct) return fail(distinct.error());
    if (auto output = check_fields_output(a.output, a.format); !output) return fail(output.error());
    if (auto writable = check_writable(a.output); !writable) return fail(writable.error());
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
    for (const Notice& notice : notices) tell_note(notice.what);
    if (run::plan_size(to->mesh).degree == 1 &&
        std::ranges::any_of(*fields, [](const NamedField& f) { return f.field.degree == 2; }))
        tell_note("the new mesh is straight and of degree 1: the fields' values at its vertices are written");
    auto made = run::fields_brought_to(to->mesh, from->mesh, std::move(*fields), a.options, around);
    if (!made) return fail(of_file(made.error(), a.solution));
    if (run::plan_size(to->mesh).degree == 1) made->fields = run::at_vertices(to->mesh, std::move(made->fields));
    auto done = written.add(a.output, run_step(around, "write", [&](const Execution& e) {
                                return write_nodal_fields(*to, made->fields, a.output, a.format, e);
                            }));
    if (!done) return fail(done.error());
    progress.wipe();
    return called_input(a.new_mesh) + "\n" + run::transfer_rows(made->report) + wrote_rows({a.output});
}

}  // namespace

int transfer_command(const TransferArguments& arguments) {
    Written written;
    const auto text = transfer_text(arguments, written);
    if (!text) return report_error(text.error());
    return end_with(*text, written);
}

}  // namespace camber::app
