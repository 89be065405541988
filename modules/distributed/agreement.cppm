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

/// What every rank has made by itself, if all have: none goes on and waits for one that has failed. All ranks call it.
/// Errors: of the lowest rank that has one.
template <class T>
[[nodiscard]] Outcome<T> agreed(Ranks& ranks, Outcome<T> made) {
    if (ranks.size() == 1) return made;
    const auto heard =
        ranks.exchange(made ? Outcome<std::vector<Bytes>>(std::vector<Bytes>(ranks.size())) : fail(made.error()));
    if (!heard) return fail(heard.error());
    return made;
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
