module;
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.distributed;
import camber.io;
import camber.ordering;
import camber.soundness;
import :execute;
import :opened_rows;

namespace camber::app {

template <int D>
Outcome<Opened<D>> mapped(const std::string& path) {
    auto bytes = map_file(path);
    if (!bytes) return fail(bytes.error());
    const std::span<const std::byte> mapping = bytes->view();
    auto rows = rows_of_gmf<D>(std::move(*bytes), path, [mapping] { give_back(mapping); });
    if (!rows) return fail(of_file(rows.error(), path));
    return Opened<D>{std::move(*rows)};
}

template <int D>
Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic(const std::string& path, Ranks& ranks) {
    auto bytes = agreed(ranks, map_file(path));
    if (!bytes) return fail(bytes.error());
    const std::span<const std::byte> mapping = bytes->view();
    auto rows = QuadraticRows<D>::make(std::move(*bytes), path, [mapping] { give_back(mapping); }, ranks);
    if (!rows) return fail(of_file(rows.error(), path));
    return rows;
}

Outcome<GmfShape> shape_of_file(const std::string& path) {
    const auto bytes = map_file(path);
    if (!bytes) return fail(bytes.error());
    const auto shape = gmf_shape(bytes->view(), path);
    if (!shape) return fail(of_file(shape.error(), path));
    return shape;
}

template <int D>
Outcome<Opened<D>> prepared(LinearMesh<D> given, std::vector<std::string>& notices, const Execution& execution) {
    auto sound = prepare(std::move(given), execution);
    if (!sound) return fail(sound.error());
    notices.insert(notices.end(), sound->notices.begin(), sound->notices.end());
    Opened<D> opened{nullptr, std::move(sound->mesh)};
    auto order = better_order(*opened.mesh, {}, execution);
    if (!order) return fail(order.error());
    if (*order) {
        auto better = renumbered(std::move(*opened.mesh), (*order)->renumbering, execution);
        if (!better) return fail(better.error());
        opened.mesh = std::move(*better);
        opened.order = std::move(*order);
    }
    opened.rows = rows_of(*opened.mesh);
    return opened;
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<Opened<D>> mapped<D>(const std::string&);                                           \
    template Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic<D>(const std::string&, Ranks&); \
    template Outcome<Opened<D>> prepared<D>(LinearMesh<D>, std::vector<std::string>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::app
