module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import :block_weights;
import :curve_runs;
import :ranks;
import :routing;
import :shared_rows;

namespace camber {

namespace {

/// What parts the curve among ranks, about evenly: a rank has what is before its own and not before that of the rank
/// below.
Outcome<std::vector<OnCurve>> splitters(Ranks& ranks, const std::vector<WeightOnCurve>& own) {
    constexpr std::size_t samples = 64;
    std::vector<OnCurve> some;
    for (std::size_t i = 0; i < samples && !own.empty(); ++i) some.push_back(own[own.size() * i / samples].at);
    auto all = gather_all(ranks, Outcome<std::vector<OnCurve>>(std::move(some)));
    if (!all) return fail(all.error());
    std::ranges::sort(*all);
    std::vector<OnCurve> out;
    for (std::size_t r = 1; r < ranks.size() && !all->empty(); ++r)
        out.push_back((*all)[all->size() * r / ranks.size()]);
    return out;
}

/// The elements of all ranks in their order: each rank has a run of it.
Outcome<std::vector<WeightOnCurve>> sorted_among_ranks(Ranks& ranks, std::vector<WeightOnCurve> own) {
    if (ranks.size() == 1) return own;
    const auto split = splitters(ranks, own);
    if (!split) return fail(split.error());
    std::vector<std::vector<WeightOnCurve>> to(ranks.size());
    for (auto begin = own.cbegin(); auto& some : to) {
        const auto r = static_cast<std::size_t>(&some - to.data());
        const auto end =
            r < split->size() ? std::ranges::lower_bound(own, (*split)[r], {}, &WeightOnCurve::at) : own.end();
        some.assign(begin, std::vector<WeightOnCurve>::const_iterator(end));
        begin = end;
    }
    own = {};
    const auto from = exchanged_lists(ranks, std::move(to));
    if (!from) return fail(from.error());
    for (const auto& some : *from) {
        const auto before = static_cast<std::ptrdiff_t>(own.size());
        own.insert(own.end(), some.begin(), some.end());
        std::ranges::inplace_merge(own, own.begin() + before, {}, &WeightOnCurve::at);
    }
    return own;
}

/// A run's number by weight alone, and its first element on a rank.
struct Start {
    std::uint64_t run = 0;
    OnCurve at;
};

}  // namespace

Outcome<std::vector<OnCurve>> starts_of_runs(Ranks& ranks, std::vector<WeightOnCurve> own, std::size_t in_a_run) {
    const auto sorted = sorted_among_ranks(ranks, std::move(own));
    if (!sorted) return fail(sorted.error());
    std::uint64_t sum = 0;
    for (const WeightOnCurve& w : *sorted) sum += w.weight;
    const auto weight = counted(ranks, sum);
    if (!weight) return fail(weight.error());
    const double elements = static_cast<double>(weight->all) / static_cast<double>(ElementWeights::one);
    const double wanted = elements / static_cast<double>(std::max<std::size_t>(in_a_run, 1));
    const auto runs = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(wanted)));
    // Weights are divided by that of a run, and not multiplied by the number of runs, which 64 bits may not hold.
    const std::uint64_t size = std::max<std::uint64_t>(1, (weight->all + runs - 1) / runs);
    std::vector<Start> here;
    std::uint64_t before = weight->before;
    for (const WeightOnCurve& w : *sorted) {
        if (here.empty() || here.back().run != before / size) here.push_back({before / size, w.at});
        before += w.weight;
    }
    const auto all = gather_all(ranks, Outcome<std::vector<Start>>(std::move(here)));
    if (!all) return fail(all.error());
    std::vector<OnCurve> starts;
    for (std::size_t i = 0; i < all->size(); ++i)
        if (i == 0 || (*all)[i].run != (*all)[i - 1].run) starts.push_back((*all)[i].at);
    return starts;
}

}  // namespace camber
