// Columns are immutable and shared; `take` avoids a copy if there is one owner.
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "property.hpp"

import camber.core;

using namespace camber;
using camber::testing::property;

namespace {

Buffer<int> buffer_of(const std::vector<int>& values) { return Buffer<int>(values.begin(), values.end()); }

}  // namespace

TEST_CASE("columns compare by value and are copied only if they are shared") {
    property("columns store their values and compare by value", [] {
        const auto values = *rc::gen::arbitrary<std::vector<int>>();
        const Column<int> a = buffer_of(values);
        const Column<int> b = buffer_of(values);
        RC_ASSERT(std::vector<int>(a.begin(), a.end()) == values);
        RC_ASSERT(a.size() == values.size());
        RC_ASSERT(a.view().size() == values.size());
        RC_ASSERT(a == b);
        auto longer = values;
        longer.push_back(0);
        RC_ASSERT(!(a == Column<int>(buffer_of(longer))));
        if (!values.empty()) {
            auto other = values;
            other.back() = other.back() == 1 ? 2 : 1;
            RC_ASSERT(!(a == Column<int>(buffer_of(other))));
        }
    });
    property("take moves a unique column and copies a shared one", [] {
        auto values = *rc::gen::arbitrary<std::vector<int>>();
        values.push_back(7);
        Column<int> unique = buffer_of(values);
        const int* place = unique.data();
        Buffer<int> moved = take(std::move(unique));
        RC_ASSERT(moved.data() == place);

        Column<int> column = std::move(moved);
        const Column<int> copy = column;
        Buffer<int> copied = take(std::move(column));
        RC_ASSERT(copied.data() != copy.data());
        copied[0] += 1;
        RC_ASSERT(std::vector<int>(copy.begin(), copy.end()) == values);

        Column<int> again = std::move(copied);
        RC_ASSERT(take(again).data() != again.data());  // an lvalue argument is a second owner
    });
}

TEST_CASE("columns share external arrays and keep their owner alive") {
    property("external arrays are shared, owned until the last copy ends, and copied by take", [] {
        const auto values = *rc::gen::arbitrary<std::vector<int>>();
        const auto owner = std::make_shared<std::vector<int>>(values);
        {
            const Column<int> column(std::span<const int>(*owner), owner);
            RC_ASSERT(owner.use_count() == 2);
            RC_ASSERT(column.data() == owner->data());
            const Column<int> other = column;
            RC_ASSERT(other == Column<int>(buffer_of(values)));
            RC_ASSERT(owner.use_count() == 2);
            const Buffer<int> taken = take(Column<int>(std::span<const int>(*owner), owner));
            RC_ASSERT(std::vector<int>(taken.begin(), taken.end()) == values);
            RC_ASSERT(taken.empty() || taken.data() != owner->data());
        }
        RC_ASSERT(owner.use_count() == 1);
    });
}

TEST_CASE("an empty column has no values") {
    const Column<double> none;
    CHECK(none.empty());
    CHECK(none.begin() == none.end());
    CHECK(none == Column<double>(Buffer<double>{}));
    CHECK(take(none).empty());
}

TEST_CASE("ids are invalid by default and ordered by index") {
    CHECK(!VertexId{}.valid());
    CHECK(VertexId(std::size_t{3}).index() == 3);
    CHECK(VertexId(std::size_t{3}) < VertexId(std::size_t{4}));
}

TEST_CASE("errors are described in one line") {
    CHECK(describe(Error{ErrorKind::input, "is flat", "wing.mesh", Entity{"tetrahedron", 12}, "remove it"}) ==
          "wing.mesh: tetrahedron 12: is flat (remove it)");
    CHECK(describe(Error{ErrorKind::internal, "broken", {}, {}, {}}) == "broken");
}
