// Rounds of non-overlapping work give the result of sequential processing for any number of threads.
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using camber::testing::Dice;
using camber::testing::property;

namespace {

/// A piece of work and the elements it reads and writes; some pieces do not declare them.
struct Piece {
    std::size_t number = 0;
    std::vector<ElementId> claims;
    bool declares_elements = true;
};

std::vector<Piece> pieces(Dice& dice, std::size_t n, std::size_t elements) {
    std::vector<Piece> all(n);
    for (std::size_t i = 0; i < n; ++i) {
        all[i].number = i;
        std::set<ElementId> claims;
        for (std::size_t k = dice.below(5); k > 0; --k) claims.insert(ElementId(dice.below(elements)));
        all[i].claims.assign(claims.begin(), claims.end());
        all[i].declares_elements = dice.below(20) > 0;
    }
    return all;
}

Claim claim_of(const Piece& piece) { return piece.declares_elements ? Claim(std::span(piece.claims)) : Claim(); }

/// The result depends on the order of pieces and on their claimed elements only.
void do_piece(const Piece& piece, std::vector<std::uint64_t>& values) {
    std::uint64_t sum = piece.number + 1;
    for (const ElementId e : piece.claims) sum = sum * 0x9e3779b97f4a7c15ULL + values[e.index()];
    for (const ElementId e : piece.claims) values[e.index()] = sum ^ e.index();
}

}  // namespace

TEST_CASE("rounds give the result of sequential processing for any number of threads") {
    property("rounds give the sequential result and omit needless pieces, for any threads", [](std::uint64_t seed) {
        Dice dice(seed);
        const std::size_t elements = 1 + dice.below(60);
        const auto all = pieces(dice, dice.below(80), elements);
        std::vector<std::uint64_t> one_by_one(elements, 7);
        for (const Piece& piece : all)
            if (piece.number % 7 != 3) do_piece(piece, one_by_one);
        for (const int threads : {1, 2, 4}) {
            Schedule schedule(elements);
            std::vector<std::uint64_t> values(elements, 7);
            std::set<std::size_t> done;
            const auto ended = run_in_rounds(
                schedule, all, Execution{.threads = threads}, [](const Piece& p) { return p.number % 7 == 3; },
                claim_of,
                [&](std::span<const Piece> round) -> Outcome<bool> {
                    RC_ASSERT(!round.empty());
                    std::set<ElementId> claimed;
                    for (const Piece& piece : round) {
                        RC_ASSERT(piece.declares_elements || round.size() == 1);
                        RC_ASSERT(done.insert(piece.number).second);
                        for (const ElementId e : piece.claims) RC_ASSERT(claimed.insert(e).second);
                    }
                    // Reverse order: the order within a round must not matter.
                    for (std::size_t i = round.size(); i-- > 0;) do_piece(round[i], values);
                    return true;
                });
            RC_ASSERT(ended.has_value());
            RC_ASSERT(values == one_by_one);
        }
    });
}

TEST_CASE("a round can end the processing") {
    Schedule schedule(4);
    const std::vector<ElementId> same{ElementId(std::size_t{2})};
    int rounds = 0;
    const auto ended = run_in_rounds(
        schedule, std::vector<int>{1, 2, 3}, Execution{.threads = 1}, [](int) { return false; },
        [&](int) { return Claim(std::span(same)); },
        [&](std::span<const int>) -> Outcome<bool> { return ++rounds < 2; });
    CHECK(ended.has_value());
    CHECK(rounds == 2);
}
