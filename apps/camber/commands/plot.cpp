module;
#include <cstddef>
#include <string>
#include <utility>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.run;
import :ending;
import :formats;
import :named_files;

namespace camber::app {

namespace {

/// One picture, or one for each quantity.
bool is_one_file(const PlotArguments& a) { return a.output.ends_with(".svg"); }

Outcome<Done> check_names(const PlotArguments& a) {
    std::vector<NamedFile> files{{a.report, "the report", Role::input}};
    for (const std::string& path : is_one_file(a) ? std::vector{a.output} : plot_files(a.output))
        files.push_back({path, "-o", Role::output});
    return check_named_files(files);
}

Outcome<Done> plot(const PlotArguments& a, Written& written) {
    if (auto distinct = check_names(a); !distinct) return distinct;
    auto text = read_file(a.report);
    if (!text) return fail(std::move(text.error()));
    const auto histograms = run::histograms_of_report(as_text(*text));
    if (!histograms)
        return fail(ErrorKind::input, "holds no histograms as Camber writes them", a.report, {},
                    "give the report.json of a run: camber curve … --report report.json");
    if (!is_one_file(a)) return write_plots(*histograms, a.output, written);
    return written.add(a.output, write_text(a.output, run::svg(*histograms)));
}

std::string plot_file(const std::string& folder, run::Quantity quantity) {
    return folder + "/" + std::string(run::info(quantity).key) + ".svg";
}

}  // namespace

std::vector<std::string> plot_files(const std::string& folder) {
    std::vector<std::string> files;
    files.reserve(run::run_quantity_count);
    for (std::size_t q = 0; q < run::run_quantity_count; ++q)
        files.push_back(plot_file(folder, static_cast<run::Quantity>(q)));
    return files;
}

Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder, Written& written) {
    if (histograms.empty()) return Done{};
    if (auto made = check_folder(folder).and_then([&](Done) { return make_folder(folder); }); !made) return made;
    for (const run::Histogram& h : histograms) {
        const std::string file = plot_file(folder, h.quantity);
        if (auto done = written.add(file, write_text(file, run::svg(h))); !done) return done;
    }
    return Done{};
}

int plot_command(const PlotArguments& arguments) {
    Written written;
    if (auto done = plot(arguments, written); !done) return report_error(done.error());
    return end_with("wrote " + called_output(arguments.output) + "\n", written);
}

}  // namespace camber::app
