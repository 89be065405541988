// Sparse containers compared with std::map.
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "dice.hpp"
#include "property.hpp"

import camber.core;

using namespace camber;
using camber::testing::Dice;
using camber::testing::property;

TEST_CASE("an overlay equals its column with the rows that were set") {
    property("an overlay equals a std::map over an array, and its copies are independent", [](std::uint64_t seed) {
        Dice dice(seed);
        const std::size_t n = 1 + dice.below(300);
        Buffer<int> rows(n);
        for (std::size_t i = 0; i < n; ++i) rows[i] = static_cast<int>(dice.below(100));
        const Column<int> base(rows);
        Overlay<EdgeId, int> overlay(base);
        RC_ASSERT(overlay.column().data() == base.data());
        std::map<EdgeId, int> model;
        const auto set_some = [&](Overlay<EdgeId, int>& some) {
            for (std::size_t k = dice.below(100); k > 0; --k) {
                const EdgeId edge(dice.below(n));
                const int value = static_cast<int>(dice.below(1000));
                some.set(edge, value);
                if (&some == &overlay) model[edge] = value;
            }
        };
        set_some(overlay);
        Overlay<EdgeId, int> copy = overlay;
        set_some(copy);
        std::vector<EdgeId> keys;
        for (const auto& [key, value] : model) {
            rows[key.index()] = value;
            keys.push_back(key);
        }
        RC_ASSERT(overlay.set_rows() == keys);
        RC_ASSERT(overlay.column() == Column<int>(rows));
        for (std::size_t i = 0; i < n; ++i) RC_ASSERT(overlay[EdgeId(i)] == rows[i]);
    });
}

TEST_CASE("a sparse set contains exactly the inserted ids") {
    SparseSet<VertexId> set;
    CHECK_FALSE(set.contains(VertexId(std::size_t{0})));
    for (std::size_t i = 0; i < 1000; i += 3) set.insert(VertexId(i));
    for (std::size_t i = 0; i < 1000; ++i) CHECK(set.contains(VertexId(i)) == (i % 3 == 0));
}

TEST_CASE("scratch tables contain the inserted keys until they are cleared") {
    ScratchSet<VertexId> set;
    ScratchMap<VertexId, int> map(2);
    for (const std::size_t step : {3U, 7U, 2U}) {
        for (std::size_t i = 0; i < 1000; i += step) {
            CHECK(set.insert(VertexId(i)));
            CHECK(map.insert(VertexId(i), static_cast<int>(i)) == static_cast<int>(i));
        }
        CHECK_FALSE(set.insert(VertexId(std::size_t{0})));
        CHECK(map.insert(VertexId(std::size_t{0}), 5) == 0);
        for (std::size_t i = 0; i < 1000; ++i) {
            const int* value = map.find(VertexId(i));
            REQUIRE((value != nullptr) == (i % step == 0));
            if (value) CHECK(*value == static_cast<int>(i));
        }
        set.clear();
        map.clear();
        CHECK(map.size() == 0);
        for (std::size_t i = 0; i < 1000; ++i) CHECK_FALSE(map.contains(VertexId(i)));
    }
}

TEST_CASE("a row table finds the first row of each key") {
    property("a row table equals a std::map", [](std::uint64_t seed) {
        Dice dice(seed);
        std::vector<std::array<std::uint64_t, 2>> keys(dice.below(200));
        for (auto& key : keys) key = {dice.below(10), dice.below(10)};
        RowTable table(keys.size());
        std::map<std::array<std::uint64_t, 2>, std::uint32_t> model;
        for (std::uint32_t row = 0; row < keys.size(); ++row) {
            const auto is_same = [&](std::uint32_t other) { return keys[other] == keys[row]; };
            RC_ASSERT(table.insert(hash_of(keys[row]), row, is_same) ==
                      model.try_emplace(keys[row], row).first->second);
        }
        for (std::uint64_t i = 0; i < 10; ++i)
            for (std::uint64_t j = 0; j < 10; ++j) {
                const std::array key{i, j};
                const auto expected = model.find(key);
                RC_ASSERT(table.find(hash_of(key), [&](std::uint32_t row) { return keys[row] == key; }) ==
                          (expected == model.end() ? RowTable::none : expected->second));
            }
    });
}

TEST_CASE("a memo returns the value of each key and does not compute it again") {
    std::atomic<int> computed = 0;
    const Memo<EdgeId, std::size_t> squares([&](EdgeId e) {
        ++computed;
        return e.index() * e.index();
    });
    const auto values = map_each(Execution{3}, 4000, [&](std::size_t i) { return squares[EdgeId(i % 100)]; }, 1);
    REQUIRE(values);
    for (std::size_t i = 0; i < values->size(); ++i) CHECK((*values)[i] == (i % 100) * (i % 100));
    CHECK(computed >= 100);
    const int before = computed;
    CHECK(squares[EdgeId(std::size_t{7})] == 49);
    CHECK(computed == before);
}
