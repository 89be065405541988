// Ranks that are threads of one process.
#pragma once

#include <barrier>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

import camber.core;
import camber.distributed;

namespace camber::testing {

class RankOfThreads final : public Ranks {
  public:
    /// Where all of them leave what they give.
    struct Table {
        explicit Table(std::size_t ranks) : given(ranks), barrier(static_cast<std::ptrdiff_t>(ranks)) {}
        std::vector<std::optional<Outcome<std::vector<Bytes>>>> given;
        std::barrier<> barrier;
    };
    RankOfThreads(Table& table, std::size_t rank) : table_(table), rank_(rank) {}

    [[nodiscard]] std::size_t rank() const override { return rank_; }
    [[nodiscard]] std::size_t size() const override { return table_.given.size(); }
    [[nodiscard]] Outcome<std::vector<Bytes>> exchange(Outcome<std::vector<Bytes>> to) override {
        table_.given[rank_] = std::move(to);
        table_.barrier.arrive_and_wait();
        auto taken = taken_by_this();
        table_.barrier.arrive_and_wait();
        ++traffic_.rounds;
        return taken;
    }
    [[nodiscard]] Traffic traffic() const override { return traffic_; }

  private:
    [[nodiscard]] Outcome<std::vector<Bytes>> taken_by_this() const {
        std::vector<Bytes> taken;
        for (const auto& from : table_.given) {
            if (!*from) return fail(from->error());
            taken.push_back((**from)[rank_]);
        }
        return taken;
    }
    Table& table_;
    std::size_t rank_;
    Traffic traffic_;
};

/// f(ranks) by so many ranks at once; the results of all.
template <class F>
auto by_ranks(std::size_t ranks, F&& f) {
    RankOfThreads::Table table(ranks);
    std::vector<std::optional<decltype(f(std::declval<Ranks&>()))>> results(ranks);
    {
        std::vector<std::jthread> threads;
        for (std::size_t r = 0; r < ranks; ++r)
            threads.emplace_back([&, r] {
                RankOfThreads rank(table, r);
                results[r].emplace(f(rank));
            });
    }
    return results;
}

}  // namespace camber::testing
