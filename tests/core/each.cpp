// Parallel loops: the same bytes for any number of threads, progress, and stop requests.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <stop_token>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using camber::testing::Dice;
using camber::testing::property;

namespace {

constexpr int thread_counts[] = {1, 2, 7, 0};

Execution with_threads(int threads) { return {.threads = threads}; }

double varied_value(std::size_t i) {
    return std::sin(static_cast<double>(i) * 12.9898) * std::pow(10.0, static_cast<double>(i % 17));
}

}  // namespace

TEST_CASE("loops do not depend on the number of threads") {
    property("each visits every item once; map_each and reduce_each do not depend on threads",
             [] {
                 const auto n = *rc::gen::arbitrary<std::uint16_t>();
                 const std::size_t grain = 1 + n % 97U;
                 std::vector<double> sums;
                 std::vector<Buffer<double>> maps;
                 for (const int threads : thread_counts) {
                     std::vector<std::atomic<int>> visits(n);
                     RC_ASSERT(each(with_threads(threads), n, [&](std::size_t i) { ++visits[i]; }, grain).has_value());
                     for (const auto& v : visits) RC_ASSERT(v.load() == 1);
                     maps.push_back(*map_each(with_threads(threads), n, varied_value, grain));
                     sums.push_back(*reduce_each(
                         with_threads(threads), n, 0.0, [](double& s, std::size_t i) { s += varied_value(i); },
                         [](double a, double b) { return a + b; }, grain));
                 }
                 for (std::size_t k = 1; k < sums.size(); ++k) {
                     RC_ASSERT(sums[k] == sums[0]);
                     RC_ASSERT(maps[k] == maps[0]);
                 }
                 for (std::size_t i = 0; i < n; ++i) RC_ASSERT(maps[0][i] == varied_value(i));
             },
             {.count = 30, .max_size = 2000});
}

TEST_CASE("chunks are whole, in range and the same for any number of threads") {
    for (const int threads : thread_counts) {
        std::vector<std::atomic<int>> ends(1001);
        CHECK(each_chunk(
                  with_threads(threads), 1000,
                  [&](std::size_t begin, std::size_t end) {
                      if (begin % 64 == 0 && end - begin <= 64) ++ends[end];
                  },
                  64)
                  .has_value());
        for (std::size_t end = 64; end <= 1000; end += 64) CHECK(ends[end].load() == 1);
        CHECK(ends[1000].load() == 1);
    }
}

TEST_CASE("loops over no items succeed") {
    CHECK(each(with_threads(3), 0, [](std::size_t) {}).has_value());
    CHECK(map_each(with_threads(3), 0, varied_value)->empty());
    const auto join = [](int a, int b) { return a + b; };
    CHECK(*reduce_each(with_threads(3), 0, 5, [](int&, std::size_t) {}, join) == 5);
}

TEST_CASE("a reduction joins its chunks in order") {
    for (const int threads : thread_counts) {
        const auto all = *reduce_each(
            with_threads(threads), 1000, std::vector<std::size_t>{},
            [](std::vector<std::size_t>& list, std::size_t i) { list.push_back(i); },
            [](std::vector<std::size_t> a, const std::vector<std::size_t>& b) {
                a.insert(a.end(), b.begin(), b.end());
                return a;
            },
            7);
        REQUIRE(all.size() == 1000);
        for (std::size_t i = 0; i < all.size(); ++i) CHECK(all[i] == i);
    }
}

TEST_CASE("a stop request ends a loop with ErrorKind::stopped") {
    for (const int threads : thread_counts) {
        std::stop_source source;
        Execution execution{.threads = threads, .stop = source.get_token()};
        std::atomic<std::size_t> visited{0};
        const auto outcome = each(
            execution, 1000000,
            [&](std::size_t) {
                if (++visited == 100) source.request_stop();
            },
            10);
        REQUIRE(!outcome.has_value());
        CHECK(outcome.error().kind == ErrorKind::stopped);
        CHECK(visited.load() < 1000000);
        CHECK(map_each(execution, 10, varied_value).error().kind == ErrorKind::stopped);
        const auto sum = reduce_each(execution, 10, 0, [](int&, std::size_t) {}, [](int a, int b) { return a + b; });
        CHECK(sum.error().kind == ErrorKind::stopped);
    }
}

TEST_CASE("progress increases, comes from one thread at a time and ends with the total") {
    for (const int threads : {1, 2, 7, 7, 7, 7}) {
        std::vector<std::pair<std::size_t, std::size_t>> ticks;
        std::atomic<int> inside{0};
        bool single = true;
        Execution execution{.threads = threads, .progress = [&](std::size_t done, std::size_t total) {
                                single = single && ++inside == 1;
                                ticks.emplace_back(done, total);
                                std::this_thread::sleep_for(std::chrono::microseconds(20));
                                --inside;
                            }};
        std::atomic<double> sink{0};
        REQUIRE(each(execution, 20000, [&](std::size_t i) { sink = varied_value(i); }, 3).has_value());
        CHECK(single);
        REQUIRE(!ticks.empty());
        for (std::size_t k = 1; k < ticks.size(); ++k) CHECK(ticks[k].first > ticks[k - 1].first);
        CHECK(ticks.back() == std::pair<std::size_t, std::size_t>{20000, 20000});
    }
}

namespace {

using Ticks = std::vector<double>;

/// An execution that records the reported shares.
Execution recording(Ticks& ticks) {
    return {.threads = 1, .progress = [&ticks](std::size_t done, std::size_t total) {
                ticks.push_back(static_cast<double>(done) / static_cast<double>(total));
            }};
}

/// Reports progress of nested parts with random shares, to this depth.
void report_parts(const Execution& execution, Dice& dice, int depth) {
    if (depth == 0) {
        const std::size_t items = 1 + dice.below(40);
        for (std::size_t done = 1; done <= items; ++done) report_progress(execution, done, items);
        return;
    }
    std::vector<double> cuts{0, 1};
    for (std::uint64_t n = dice.below(4); n > 0; --n) cuts.push_back(dice.uniform(0, 1));
    std::ranges::sort(cuts);
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k)
        report_parts(part_of(execution, cuts[k], cuts[k + 1]), dice, depth - 1);
}

}  // namespace

// Guards against stages of several loops that report no share of their work.
TEST_CASE("progress of nested parts increases and ends with the total") {
    property("the reported progress of nested parts increases from 0 to 1", [](std::uint64_t seed) {
        Dice dice(seed);
        Ticks ticks;
        report_parts(recording(ticks), dice, static_cast<int>(dice.below(5)));
        RC_ASSERT(std::ranges::is_sorted(ticks));
        RC_ASSERT(ticks.front() >= 0);
        RC_ASSERT(ticks.back() == 1);
    });
}

TEST_CASE("nested parts of an execution are combined into one part") {
    property("part_of(part_of(e, a, b), c, d) is part_of(e, a + (b - a) c, a + (b - a) d)", [](std::uint64_t seed) {
        Dice dice(seed);
        const double a = dice.uniform(0, 1), b = dice.uniform(a, 1), c = dice.uniform(0, 1), d = dice.uniform(c, 1);
        Ticks nested, direct;
        const Execution twice = part_of(part_of(recording(nested), a, b), c, d);
        const Execution once = part_of(recording(direct), a + (b - a) * c, a + (b - a) * d);
        for (const Execution& e : {twice, once}) REQUIRE(each(e, 1000, [](std::size_t) {}, 100));
        REQUIRE(nested.size() == direct.size());
        for (std::size_t k = 0; k < nested.size(); ++k) RC_ASSERT(std::abs(nested[k] - direct[k]) < 1e-8);
    });
}

TEST_CASE("a part of an execution without progress reports none") {
    const Execution silent = part_of({.threads = 3}, 0.1, 0.2);
    CHECK(silent.threads == 3);
    CHECK_FALSE(silent.progress);
    report_progress(silent, 1, 2);
}

TEST_CASE("allocation failures in any thread are errors of the loop") {
    for (const int threads : thread_counts) {
        const auto done = each(with_threads(threads), 10000, [](std::size_t i) {
            if (i == 7777) throw std::bad_alloc();
        });
        REQUIRE(!done);
        CHECK(done.error().kind == ErrorKind::memory);
        const auto map = map_each(with_threads(threads), std::size_t{1} << 60U, [](std::size_t) { return 1.0; });
        REQUIRE(!map);
        CHECK(map.error().kind == ErrorKind::memory);
        const auto sum = reduce_each(
            with_threads(threads), 100000, 0.0,
            [](double&, std::size_t i) {
                if (i == 50000) throw std::length_error("long");
            },
            [](double a, double b) { return a + b; });
        REQUIRE(!sum);
        CHECK(sum.error().kind == ErrorKind::memory);
        const auto refused = each(with_threads(threads), 1, [](std::size_t) {
            throw std::runtime_error("pthread_create has failed: no thread");
        });
        REQUIRE(!refused);
        CHECK(refused.error().what.ends_with("no thread"));
    }
}

TEST_CASE("guarded returns memory and thread failures as errors and passes other exceptions") {
    const auto thrown = [](auto exception) { return guarded([&]() -> Outcome<Done> { throw exception; }); };
    CHECK(thrown(std::bad_alloc()).error().kind == ErrorKind::memory);
    CHECK(thrown(std::length_error("vector")).error().kind == ErrorKind::memory);
    CHECK(thrown(std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again))).error().remedy ==
          "use fewer threads: --threads 1");
    CHECK(thrown(std::runtime_error("pthread_create has failed: Resource temporarily unavailable")).error().kind ==
          ErrorKind::memory);
    CHECK_THROWS_AS(static_cast<void>(thrown(std::runtime_error("a stack is empty"))), std::runtime_error);
}
