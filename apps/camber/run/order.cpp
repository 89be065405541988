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
    Places places;
};

Row row_of(const config::Stage& stage) {
    return std::visit(
        []<class Options>(const Options&) {
            const auto& row = std::get<StageRow<Options>>(stage_rows);
            return Row{std::string(row.name), row.least, row.most, row.makes, row.places};
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

/// Why it cannot run on more: it elevates a straight mesh.
Error too_much(int degree) {
    if (degree == 1)
        return {ErrorKind::usage,
                "the mesh is quadratic already, by an \"elevate\" before",
                {},
                {},
                "leave one of them out"};
    return {ErrorKind::input,
            "the mesh is quadratic already",
            {},
            {},
            "give the straight one, or leave the stage \"elevate\" out: stages=[\"curve\", \"validate\", \"relax\", "
            "\"commit\"]"};
}

/// Why it cannot change a mesh for whose nodes other places are planned.
Error not_committed(const Row& row) {
    return {ErrorKind::usage,
            "stage \"" + row.name + "\" changes the mesh, and planned places of its nodes are not committed",
            {},
            {},
            "put \"commit\" before it"};
}

}  // namespace

Outcome<Done> check_order(std::span<const config::Stage> stages, int degree) {
    Holds now = degree == 1 ? Holds::straight_mesh : Holds::planned_nodes;
    bool committed = true;
    for (std::size_t i = 0; i < stages.size(); ++i) {
        const Row row = row_of(stages[i]);
        const bool fits = row.least <= now && now <= row.most;
        if (fits && (committed || row.places != Places::refuses)) {
            now = row.makes.value_or(now);
            if (row.places == Places::plans) committed = false;
            if (row.places == Places::commits) committed = true;
            continue;
        }
        Error error = fits ? not_committed(row) : now < row.least ? too_little(row, now) : too_much(degree);
        if (error.kind == ErrorKind::usage) error.where = "/stages/" + std::to_string(i);
        return fail(std::move(error));
    }
    return Done{};
}

}  // namespace camber::run
