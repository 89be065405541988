module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.adapt;
import :adaptation_rows;
import :ranks;
import :share_parts;

namespace camber {

namespace {

/// Plain values one after the other, a count before each row of them.
class Packing {
  public:
    explicit Packing(Bytes& bytes) : bytes_(bytes) {}
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        append(&value, sizeof(T));
    }
    template <class T>
    void put(const Buffer<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        put(std::uint64_t{values.size()});
        append(values.data(), values.size() * sizeof(T));
    }

  private:
    void append(const void* from, std::size_t size) {
        const std::size_t before = bytes_.size();
        bytes_.resize(before + size);
        if (size > 0) std::memcpy(bytes_.data() + before, from, size);
    }
    Bytes& bytes_;
};
class Unpacking {
  public:
    explicit Unpacking(const Bytes& bytes) : left_(bytes) {}
    template <class T>
    void get(T& value) {
        take(&value, sizeof(T));
    }
    template <class T>
    void get(Buffer<T>& values) {
        std::uint64_t count = 0;
        get(count);
        values.resize(count);
        take(values.data(), count * sizeof(T));
    }
    [[nodiscard]] bool is_done() const { return left_.empty(); }

  private:
    void take(void* to, std::size_t size) {
        if (size > 0) std::memcpy(to, left_.data(), size);
        left_ = left_.subspan(size);
    }
    std::span<const std::byte> left_;
};

/// f(row) for all that a part is made of.
template <class Part>
void each_piece(Part& part, auto&& f) {
    f(part.statistics);
    f(part.rows.vertices);
    f(part.rows.elements);
    f(part.rows.facets);
    f(part.rows.lines);
}

template <int D>
Bytes packed(const std::vector<ChangedPart<D>>& parts) {
    Bytes bytes;
    Packing packing(bytes);
    for (const ChangedPart<D>& part : parts) each_piece(part, [&](const auto& piece) { packing.put(piece); });
    return bytes;
}
template <int D>
void unpack(const Bytes& bytes, std::vector<ChangedPart<D>>& parts) {
    for (Unpacking unpacking(bytes); !unpacking.is_done();)
        each_piece(parts.emplace_back(), [&](auto& piece) { unpacking.get(piece); });
}

}  // namespace

OwnParts own_parts(const Ranks& ranks, std::size_t parts) {
    return {parts * ranks.rank() / ranks.size(), parts * (ranks.rank() + 1) / ranks.size()};
}

template <int D>
Outcome<std::vector<ChangedPart<D>>> shared_parts(Ranks& ranks, Outcome<std::vector<ChangedPart<D>>> own) {
    return guarded([&]() -> Outcome<std::vector<ChangedPart<D>>> {
        if (ranks.size() == 1) return std::move(own);
        std::vector<Bytes> to(ranks.size());
        if (own)
            for (std::size_t r = 0; r < to.size(); ++r)
                if (r != ranks.rank()) to[r] = packed(*own);
        auto from = ranks.exchange(own ? Outcome<std::vector<Bytes>>(std::move(to)) : fail(own.error()));
        if (!from) return fail(from.error());
        std::vector<ChangedPart<D>> all;
        for (std::size_t r = 0; r < from->size(); ++r)
            if (r == ranks.rank())
                std::ranges::move(*own, std::back_inserter(all));
            else
                unpack((*from)[r], all);
        return all;
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<std::vector<ChangedPart<D>>> shared_parts<D>(Ranks&, Outcome<std::vector<ChangedPart<D>>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
