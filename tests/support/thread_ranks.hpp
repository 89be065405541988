// Ranks as threads of one process, for tests of distributed algorithms.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

import camber.core;
import camber.distributed;

namespace camber::testing {

/// All-to-all exchange between the ranks: each rank stores its messages and takes those of the others when all have
/// stored theirs.
class ThreadPost {
  public:
    explicit ThreadPost(std::size_t ranks) : messages_(ranks) {}

    Outcome<std::vector<Bytes>> exchange(std::size_t rank, Outcome<std::vector<Bytes>> to) {
        std::unique_lock lock(mutex_);
        messages_[rank] = std::move(to);
        wait(lock);
        Outcome<std::vector<Bytes>> from{std::vector<Bytes>{}};
        for (const auto& sent : messages_) {
            if (!sent && from) from = fail(sent.error());
            if (from) from->push_back((*sent)[rank]);
        }
        wait(lock);
        return from;
    }
    [[nodiscard]] std::size_t size() const { return messages_.size(); }

  private:
    void wait(std::unique_lock<std::mutex>& lock) {
        const std::size_t turn = turn_;
        if (++arrived_ == messages_.size()) {
            arrived_ = 0;
            ++turn_;
            met_.notify_all();
        } else
            met_.wait(lock, [&] { return turn_ != turn; });
    }

    std::mutex mutex_;
    std::condition_variable met_;
    std::vector<Outcome<std::vector<Bytes>>> messages_;
    std::size_t arrived_ = 0, turn_ = 0;
};

class ThreadRank final : public Ranks {
  public:
    ThreadRank(ThreadPost& post, std::size_t rank) : post_(&post), rank_(rank) {}
    [[nodiscard]] std::size_t rank() const override { return rank_; }
    [[nodiscard]] std::size_t size() const override { return post_->size(); }
    [[nodiscard]] Traffic traffic() const override { return traffic_; }

  private:
    [[nodiscard]] Outcome<std::vector<Bytes>> exchanged(Outcome<std::vector<Bytes>> to) override {
        ++traffic_.rounds;
        if (to)
            for (std::size_t r = 0; r < to->size(); ++r)
                if (r != rank_ && !(*to)[r].empty()) ++traffic_.messages, traffic_.bytes += (*to)[r].size();
        return post_->exchange(rank_, std::move(to));
    }

    ThreadPost* post_;
    std::size_t rank_;
    Traffic traffic_;
};

/// Runs work(ranks) on `count` ranks and returns their results.
template <class Work>
auto on_ranks(std::size_t count, const Work& work) {
    using Result = decltype(work(std::declval<Ranks&>()));
    ThreadPost post(count);
    std::vector<std::optional<Result>> results(count);
    std::vector<std::jthread> threads;
    for (std::size_t r = 0; r < count; ++r)
        threads.emplace_back([&, r] {
            ThreadRank rank(post, r);
            results[r].emplace(work(rank));
        });
    threads.clear();
    std::vector<Result> out;
    for (auto& m : results) out.push_back(std::move(*m));
    return out;
}

}  // namespace camber::testing
