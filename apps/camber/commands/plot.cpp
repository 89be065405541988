module;
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.run;
import :execute;
import :formats;

namespace camber::app {

namespace {

Outcome<Done> plot(const PlotArguments& a) {
    auto text = read_file(a.report);
    if (!text) return fail(std::move(text.error()));
    const auto histograms = run::histograms_of_report(as_text(*text));
    if (!histograms)
        return fail(ErrorKind::input, "holds no histograms as Camber writes them", a.report, {},
                    "give the report.json of a run: camber curve … --report report.json");
    if (a.output.ends_with(".svg"))
        return make_folder_of(a.output).and_then([&](Done) { return write_text(a.output, run::svg(*histograms)); });
    return write_plots(*histograms, a.output);
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

Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder) {
    for (const run::Histogram& h : histograms) {
        const std::string file = plot_file(folder, h.quantity);
        auto done = make_folder_of(file).and_then([&](Done) { return write_text(file, run::svg(h)); });
        if (!done) return done;
    }
    return Done{};
}

int plot_command(const PlotArguments& arguments) {
    if (auto done = plot(arguments); !done) return report_error(done.error());
    fmt::print("wrote {}\n", arguments.output);
    return 0;
}

}  // namespace camber::app
