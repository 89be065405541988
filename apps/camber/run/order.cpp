module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.config;
import :order;

namespace camber::run {

namespace {

/// A row without the type of its options.
struct Row {
    std::string name;
    Holds least, most;
    std::optional<Holds> makes;
};

Row row_of(const config::Stage& stage) {
    return std::visit(
        []<class Options>(const Options&) {
            const auto& row = std::get<StageRow<Options>>(stage_rows);
            return Row{std::string(row.name), row.least, row.most, row.makes};
        },
        stage);
}

/// The first stage of the table that makes this.
std::string_view maker_of(Holds wanted) {
    std::string_view maker;
    std::apply([&](const auto&... rows) { ((maker = maker.empty() && rows.makes == wanted ? rows.name : maker), ...); },
               stage_rows);
    return maker;
}

/// Why the stage cannot run on less than it needs.
Error too_little(const Row& row, Holds now) {
    // A stage that takes what is there finds a mesh of another degree; one that plans anew could have had it elevated.
    if (now == Holds::straight_mesh && !row.makes)
        return {ErrorKind::input,
                "the mesh is of degree 1, and stage \"" + row.name + "\" needs one of degree 2",
                {},
                {},
                "camber curve makes it curved; in a config, put \"elevate\" before"};
    const Holds missing = now == Holds::straight_mesh ? Holds::curved_mesh : row.least;
    return {ErrorKind::usage,
            "stage \"" + row.name + "\" needs \"" + std::string(maker_of(missing)) + "\" before it",
            {},
            {},
            {}};
}

/// Why it cannot run on more: it takes a straight mesh, to elevate it or to change it.
Error too_much(const Row& row, int degree) {
    const bool elevates = row.makes.has_value();
    if (degree == 1)
        return {ErrorKind::usage,
                "the mesh is quadratic already, by an \"elevate\" before",
                {},
                {},
                elevates ? "leave one of them out" : "put \"" + row.name + "\" before \"elevate\""};
    return {
        ErrorKind::input,
        "the mesh is quadratic already" + (elevates ? "" : ", and stage \"" + row.name + "\" changes straight ones"),
        {},
        {},
        elevates ? "give the straight one, or leave the stage \"elevate\" out: stages=[\"curve\", \"validate\", "
                   "\"relax\", \"commit\"]"
                 : "give the straight one"};
}

}  // namespace

Outcome<Done> check_order(std::span<const config::Stage> stages, int degree) {
    Holds now = degree == 1 ? Holds::straight_mesh : Holds::planned_nodes;
    for (std::size_t i = 0; i < stages.size(); ++i) {
        const Row row = row_of(stages[i]);
        if (row.least <= now && now <= row.most) {
            now = row.makes.value_or(now);
            continue;
        }
        Error error = now < row.least ? too_little(row, now) : too_much(row, degree);
        if (error.kind == ErrorKind::usage) error.where = "/stages/" + std::to_string(i);
        return fail(std::move(error));
    }
    return Done{};
}

}  // namespace camber::run
