module;
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.io;
import camber.run;
import :execute;

namespace camber::app {

namespace {

constexpr std::size_t elements_at_once = 65536;

/// f(begin, end) for all elements, some at a time: their text is never in memory as a whole.
template <class F>
void in_pieces(std::size_t elements, F&& f) {
    for (std::size_t begin = 0; begin < elements; begin += elements_at_once)
        f(begin, std::min(begin + elements_at_once, elements));
}

/// Standard output, whose reader may go before all is said (`| head`): that is no failure, a full disk is one.
class Printer {
  public:
    void print(std::string_view text) {
        if (error_ == 0 && std::fwrite(text.data(), 1, text.size(), stdout) < text.size()) error_ = errno;
    }
    [[nodiscard]] Outcome<Done> finish() {
        if (error_ == 0 && std::fflush(stdout) != 0) error_ = errno;
        if (error_ == 0 || error_ == EPIPE) return Done{};
        return fail(ErrorKind::write, "cannot be written: " + std::generic_category().message(error_),
                    "standard output");
    }

  private:
    int error_ = 0;
};

void print_json(const run::CheckReport& report, const CheckArguments& arguments, Printer& out) {
    out.print(run::check_json_head(report, arguments.input));
    if (arguments.elements) {
        out.print(",\n  \"element_verdicts\": {");
        const char* before = "\n";
        for (const std::string& column : run::column_names(report)) {
            out.print(fmt::format("{}    \"{}\": [", before, column));
            in_pieces(report.mesh.elements, [&](std::size_t begin, std::size_t end) {
                out.print(run::column_items(report, column, begin, end));
            });
            out.print("]");
            before = ",\n";
        }
        out.print("\n  }");
    }
    out.print("\n}\n");
}

void print_elements(const run::CheckReport& report, Printer& out) {
    out.print(run::csv_titles(report));
    in_pieces(report.mesh.elements,
              [&](std::size_t begin, std::size_t end) { out.print(run::csv_lines(report, begin, end)); });
}

void print_report(const run::CheckReport& report, const CheckArguments& arguments, Printer& out) {
    out.print(arguments.input + "\n" + run::check_table(report));
    if (arguments.histogram)
        for (const run::Histogram& histogram : report.histograms) out.print(run::bars(histogram));
}

Outcome<run::CheckReport> checked(const CheckArguments& arguments) {
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const run::Around around = [&](std::string_view stage, const std::function<Outcome<Done>(const Execution&)>& body) {
        progress.begin(std::string(stage));
        return body(Execution{.threads = arguments.threads, .stop = stop, .progress = progress.ticks()});
    };
    std::optional<DecodedMesh> mesh;
    auto read = around("read", [&](const Execution& execution) -> Outcome<Done> {
        auto decoded = read_mesh(arguments.input, execution);
        if (!decoded) return fail(decoded.error());
        mesh = std::move(*decoded);
        return Done{};
    });
    if (!read) return fail(read.error());
    const run::CheckOptions options{arguments.min_scaled_jacobian, arguments.ridge_angle, arguments.worst};
    auto report = run::check_mesh(std::move(*mesh), options, around);
    progress.wipe();
    if (!report) return fail(of_file(report.error(), arguments.input));
    return report;
}

}  // namespace

int check_command(const CheckArguments& arguments) {
    const auto report = checked(arguments);
    if (!report) return report_error(report.error());
    if (!arguments.json)
        for (const std::string& notice : report->notices) fmt::print(stderr, "camber: note: {}\n", notice);
    Printer out;
    if (arguments.json)
        print_json(*report, arguments, out);
    else if (arguments.elements)
        print_elements(*report, out);
    else
        print_report(*report, arguments, out);
    if (auto done = out.finish(); !done) return report_error(done.error());
    return report->all_good() ? 0 : 1;
}

}  // namespace camber::app
