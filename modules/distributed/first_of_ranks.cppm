module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>
module camber.distributed:first_of_ranks;
import camber.core;
import :ranks;
import :routing;
import :shared_rows;

namespace camber {

/// Of simplices that several ranks may have, by the rising numbers of their vertices: whether this is the first of
/// them.
template <std::size_t N>
[[nodiscard]] Outcome<std::vector<std::uint8_t>> are_first(const std::vector<std::array<VertexId, N>>& simplices,
                                                           const std::vector<std::size_t>& first_vertices,
                                                           Ranks& ranks) {
    using Numbers = std::array<VertexId, N>;
    const auto rank_of = [&](const Numbers& one) { return rank_with(first_vertices, one.front().index()); };
    std::vector<std::vector<Numbers>> to(ranks.size());
    for (const Numbers& one : simplices) to[rank_of(one)].push_back(one);
    const auto asked = exchanged_lists(ranks, std::move(to));
    if (!asked) return fail(asked.error());
    std::set<Numbers> told;
    std::vector<std::vector<std::uint8_t>> answers(ranks.size());
    for (std::size_t r = 0; r < asked->size(); ++r)
        for (const Numbers& one : (*asked)[r]) answers[r].push_back(told.insert(one).second ? 1 : 0);
    const auto heard = exchanged_lists(ranks, std::move(answers));
    if (!heard) return fail(heard.error());
    std::vector<std::size_t> next(ranks.size(), 0);
    std::vector<std::uint8_t> first;
    first.reserve(simplices.size());
    for (const Numbers& one : simplices) first.push_back((*heard)[rank_of(one)][next[rank_of(one)]++]);
    return first;
}

}  // namespace camber
