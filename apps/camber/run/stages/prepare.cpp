module;
#include <optional>
#include <span>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
import camber.config;
import camber.ordering;
import camber.soundness;
import :numbering;
import :stages;
import :state;

namespace camber::run {

namespace {

/// A mesh as it is used, and what is to be said of it.
template <int D>
struct Mended {
    GivenMesh<D> mesh;
    Notices notices;
};
template <int D>
Outcome<Mended<D>> mended(GivenMesh<D> mesh, const Execution& execution) {
    return std::visit(
        [&](auto given) -> Outcome<Mended<D>> {
            auto prepared = prepare(std::move(given), execution);
            if (!prepared) return fail(prepared.error());
            return Mended<D>{std::move(prepared->mesh), std::move(prepared->notices)};
        },
        std::move(mesh));
}

/// In the order to work in, which makes this too faster; nothing where there is something to say of the mesh, since
/// that is said of the given one.
template <int D>
Outcome<std::optional<Sound<D>>> sound_in_order(const StageInputs<D>& given, BetterOrder order,
                                                const Execution& execution) {
    auto inputs = in_working_order(given, order.renumbering, part_of(execution, 0, 0.2));
    if (!inputs) return fail(inputs.error());
    auto made = mended<D>(std::move(inputs->mesh), part_of(execution, 0.2, 1));
    if (!made || !made->notices.empty()) return std::nullopt;
    return Sound<D>{{std::move(made->mesh), std::move(inputs->files)}, {}, std::move(order)};
}

}  // namespace

template <int D>
Outcome<Sound<D>> prepare_stage(StageInputs<D> given, std::span<const config::Stage> stages,
                                const OrderingOptions& ordering, const Execution& execution) {
    auto order = working_order(given, stages, ordering, part_of(execution, 0, 0.02));
    if (!order) return fail(order.error());
    const bool is_bad = order->has_value();
    if (is_bad) {
        auto sound = sound_in_order(given, std::move(**order), part_of(execution, 0.02, 0.9));
        if (!sound) return fail(sound.error());
        if (*sound) return std::move(**sound);
    }
    auto made = mended<D>(std::move(given.mesh), part_of(execution, is_bad ? 0.9 : 0.02, 1));
    if (!made) return fail(made.error());
    given.mesh = std::move(made->mesh);
    Sound<D> sound{std::move(given), std::move(made->notices), {}};
    if (!is_bad) return sound;
    // Anew: elements may have gone.
    auto now = working_order(sound.inputs, stages, ordering, without_progress(execution));
    if (!now) return fail(now.error());
    if (!*now) return sound;
    auto inputs = in_working_order(std::move(sound.inputs), (*now)->renumbering, without_progress(execution));
    if (!inputs) return fail(inputs.error());
    return Sound<D>{std::move(*inputs), std::move(sound.notices), std::move(*now)};
}

#define CAMBER_INSTANTIATE(D)                                                                   \
    template Outcome<Sound<D>> prepare_stage<D>(StageInputs<D>, std::span<const config::Stage>, \
                                                const OrderingOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
