module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
export module camber.distributed:routing;
import camber.core;
import :ringed_parts;
import :ranks;

export namespace camber {

/// Something for a part, wherever that is.
template <class T>
struct ToPart {
    std::uint64_t part = 0;
    T what;
};

/// Takes things to the ranks that hold their parts: a list for each of this rank's, with what lower ranks sent first,
/// in the order in which it was given. Errors: of any rank.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<std::vector<std::vector<T>>> route(Ranks& ranks, const PartLayout& layout,
                                                         Outcome<std::vector<ToPart<T>>> things) {
    Outcome<std::vector<Bytes>> to{std::vector<Bytes>{}};
    if (things) {
        std::vector<std::vector<ToPart<T>>> of_ranks(ranks.size());
        if (ranks.size() == 1)
            of_ranks.front() = std::move(*things);
        else
            for (const auto& thing : *things) of_ranks[layout.rank_of(thing.part)].push_back(thing);
        for (auto& some : of_ranks) {
            to->push_back(bytes_of<ToPart<T>>(some));
            some = {};
        }
    } else
        to = fail(things.error());
    const auto from = ranks.exchange(std::move(to));
    if (!from) return fail(from.error());
    const std::size_t begin = layout.begin_of(ranks.rank()), end = layout.end_of(ranks.rank());
    std::vector<std::vector<T>> received(end - begin);
    for (const Bytes& bytes : *from) {
        std::vector<ToPart<T>> some;
        append_values(bytes, some);
        for (ToPart<T>& thing : some) received[thing.part - begin].push_back(thing.what);
    }
    return received;
}

/// Lists of plain values, one to each rank, and those that each has sent to this one. Errors: of any rank.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<std::vector<std::vector<T>>> exchanged_lists(Ranks& ranks, std::vector<std::vector<T>> to) {
    if (ranks.size() == 1) return to;
    std::vector<Bytes> bytes;
    bytes.reserve(to.size());
    for (auto& some : to) {
        bytes.push_back(bytes_of<T>(some));
        some = {};
    }
    auto from = ranks.exchange(std::move(bytes));
    if (!from) return fail(from.error());
    std::vector<std::vector<T>> lists(from->size());
    for (std::size_t r = 0; r < lists.size(); ++r) append_values(std::exchange((*from)[r], {}), lists[r]);
    return lists;
}

/// The same, what all have sent one after the other; where a rank has an error instead, all have it.
template <class T>
    requires std::is_trivially_copyable_v<T>
[[nodiscard]] Outcome<std::vector<T>> exchanged_values(Ranks& ranks, Outcome<std::vector<std::vector<T>>> to) {
    Outcome<std::vector<Bytes>> bytes = std::vector<Bytes>();
    if (!to) bytes = fail(to.error());
    if (to)
        for (auto& some : *to) bytes->push_back(bytes_of<T>(std::exchange(some, {})));
    auto from = ranks.exchange(std::move(bytes));
    if (!from) return fail(from.error());
    std::vector<T> all;
    for (Bytes& some : *from) append_values(std::exchange(some, {}), all);
    return all;
}

/// Asks parts: answer(own part, key) is called where the part is; one a question, in the order of the questions.
/// Errors: of any rank.
template <class Answer, class Key, class F>
    requires std::is_trivially_copyable_v<Key> && std::is_trivially_copyable_v<Answer>
[[nodiscard]] Outcome<std::vector<Answer>> ask(Ranks& ranks, const PartLayout& layout,
                                               const std::vector<ToPart<Key>>& questions, const F& answer) {
    std::vector<std::vector<ToPart<Key>>> of_ranks(ranks.size());
    for (const auto& question : questions) of_ranks[layout.rank_of(question.part)].push_back(question);
    std::vector<Bytes> to;
    to.reserve(of_ranks.size());
    for (const auto& some : of_ranks) to.push_back(bytes_of<ToPart<Key>>(some));
    auto asked = ranks.exchange(std::move(to));
    if (!asked) return fail(asked.error());
    std::vector<Bytes> answers;
    for (const Bytes& bytes : *asked) {
        std::vector<ToPart<Key>> some;
        append_values(bytes, some);
        std::vector<Answer> given;
        given.reserve(some.size());
        for (const auto& question : some)
            given.push_back(answer(question.part - layout.begin_of(ranks.rank()), question.what));
        answers.push_back(bytes_of<Answer>(given));
    }
    auto back = ranks.exchange(std::move(answers));
    if (!back) return fail(back.error());
    std::vector<std::vector<Answer>> by_rank(ranks.size());
    for (std::size_t r = 0; r < by_rank.size(); ++r) append_values((*back)[r], by_rank[r]);
    std::vector<std::size_t> next(ranks.size(), 0);
    std::vector<Answer> out;
    out.reserve(questions.size());
    for (const auto& question : questions) {
        const std::size_t r = layout.rank_of(question.part);
        out.push_back(by_rank[r][next[r]++]);
    }
    return out;
}

}  // namespace camber
