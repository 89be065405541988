module;
#include <cstddef>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.distributed:agreement;
import camber.core;
import :ranks;

export namespace camber {

/// What came of a step on all ranks: done, or the error of the lowest rank that has one. All ranks call it.
[[nodiscard]] inline Outcome<Done> agreed(Ranks& ranks, const Outcome<Done>& own) {
    auto all = ranks.exchange(own ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size())) : fail(own.error()));
    if (!all) return fail(std::move(all.error()));
    return Done{};
}

/// The first rank's value (a plain one, or a text) on all of them; what the others give is not looked at. Errors: of
/// any.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<T> told_by_first(Ranks& ranks, const Outcome<T>& own) {
    Outcome<std::vector<T>> given = std::vector<T>();
    if (!own) given = fail(own.error());
    if (own && ranks.rank() == 0) given->push_back(*own);
    auto all = gather_all(ranks, given);
    if (!all) return fail(std::move(all.error()));
    return all->front();
}
[[nodiscard]] inline Outcome<std::string> told_by_first(Ranks& ranks, const Outcome<std::string>& own) {
    Outcome<std::vector<char>> given = std::vector<char>();
    if (!own) given = fail(own.error());
    if (own && ranks.rank() == 0) given->assign(own->begin(), own->end());
    const auto all = gather_all(ranks, given);
    if (!all) return fail(all.error());
    return std::string(all->begin(), all->end());
}

}  // namespace camber
