// Single-process ranks, serialised errors, and the halo exchange.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.extension;
import camber.curving;

namespace camber {

namespace {

class OneRank final : public Ranks {
  public:
    [[nodiscard]] std::size_t rank() const override { return 0; }
    [[nodiscard]] std::size_t size() const override { return 1; }
    [[nodiscard]] Traffic traffic() const override { return {.rounds = rounds_}; }

  private:
    [[nodiscard]] Outcome<std::vector<Bytes>> exchanged(Outcome<std::vector<Bytes>> to) override {
        ++rounds_;
        return to;
    }

    std::size_t rounds_ = 0;
};

}  // namespace

std::unique_ptr<Ranks> one_rank() { return std::make_unique<OneRank>(); }

namespace {

void put(Bytes& bytes, std::uint64_t number) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof number);
    std::memcpy(bytes.data() + at, &number, sizeof number);
}
void put(Bytes& bytes, const std::string& text) {
    put(bytes, text.size());
    const std::size_t at = bytes.size();
    bytes.resize(at + text.size());
    if (!text.empty()) std::memcpy(bytes.data() + at, text.data(), text.size());
}

/// Reads values in the order in which `put` wrote them. Missing values are 0 or empty.
class Taker {
  public:
    explicit Taker(const Bytes& bytes) : bytes_(bytes) {}
    [[nodiscard]] std::uint64_t number() {
        std::uint64_t number = 0;
        if (bytes_.size() - at_ < sizeof number) return 0;
        std::memcpy(&number, bytes_.data() + at_, sizeof number);
        at_ += sizeof number;
        return number;
    }
    [[nodiscard]] std::string text() {
        const std::uint64_t size = number();
        if (bytes_.size() - at_ < size) return {};
        std::string text(size, '\0');
        if (size > 0) std::memcpy(text.data(), bytes_.data() + at_, size);
        at_ += size;
        return text;
    }

  private:
    const Bytes& bytes_;
    std::size_t at_ = 0;
};

}  // namespace

Bytes packed(const Error& error) {
    Bytes bytes;
    put(bytes, static_cast<std::uint64_t>(error.kind));
    for (const std::string* const text : {&error.what, &error.where, &error.remedy}) put(bytes, *text);
    put(bytes, std::uint64_t{error.entity ? 1U : 0U});
    if (error.entity) {
        put(bytes, error.entity->kind);
        put(bytes, error.entity->number);
    }
    return bytes;
}

Error unpacked_error(const Bytes& bytes) {
    Taker take(bytes);
    Error error;
    error.kind = static_cast<ErrorKind>(take.number());
    for (std::string* const text : {&error.what, &error.where, &error.remedy}) *text = take.text();
    if (take.number() == 0) return error;
    std::string kind = take.text();
    error.entity = Entity{std::move(kind), take.number()};
    return error;
}

namespace {

template <class Key>
struct RowRequest {
    Key key;
    std::uint64_t part = 0;
    Halo::Row into;
};

template <class Key>
Outcome<Halo> halo_of(std::vector<Buffer<RowRequest<Key>>> requests, const PartLayout& layout, Ranks& ranks,
                      const auto& row_of) {
    struct Question {
        std::uint64_t part = 0;
        Key key;
    };
    Halo halo;
    std::vector<Bytes> to;
    for (const auto& of_rank : requests) {
        Buffer<Question> questions;
        questions.reserve(of_rank.size());
        Buffer<Halo::Row> into;
        into.reserve(of_rank.size());
        for (const RowRequest<Key>& a : of_rank) {
            questions.push_back({a.part, a.key});
            into.push_back(a.into);
        }
        to.push_back(bytes_of<Question>(questions));
        halo.get.push_back(std::move(into));
    }
    requests = {};
    const auto from = ranks.exchange(std::move(to));
    if (!from) return fail(from.error());
    const std::size_t begin = layout.begin_of(ranks.rank());
    for (const Bytes& bytes : *from) {
        Buffer<Question> questions;
        append_values(bytes, questions);
        Buffer<Halo::Row> rows;
        rows.reserve(questions.size());
        for (const Question& q : questions) {
            const auto part = static_cast<std::uint32_t>(q.part - begin);
            rows.push_back({part, row_of(part, q.key)});
        }
        halo.send.push_back(std::move(rows));
    }
    return halo;
}

}  // namespace

template <int D>
Outcome<Halo> vertex_halo(const RingedParts<D>& parts, Ranks& ranks) {
    return guarded([&]() -> Outcome<Halo> {
        const PartLayout& layout = parts.layout;
        std::vector<Buffer<RowRequest<GlobalNumber>>> requests(ranks.size());
        for (std::uint32_t b = 0; b < parts.own.size(); ++b) {
            const RingedPart<D>& part = parts.own[b];
            for (std::uint32_t v = 0; v < part.vertices.size(); ++v) {
                if (part.owns(VertexId(v))) continue;
                const std::size_t owner = layout.part_with(part.vertices[v]);
                requests[layout.rank_of(owner)].push_back({part.vertices[v], owner, {b, v}});
            }
        }
        return halo_of<GlobalNumber>(std::move(requests), layout, ranks, [&](std::uint32_t b, GlobalNumber number) {
            const RingedPart<D>& part = parts.own[b];
            const GlobalNumber first = layout.first_vertices[layout.begin_of(ranks.rank()) + b];
            return static_cast<std::uint32_t>(part.first.index() + (number - first));
        });
    });
}

template <int D>
Outcome<Halo> edge_halo(const RingedParts<D>& parts, std::span<const EdgeSet<D>> edges, Ranks& ranks) {
    using Ends = std::array<GlobalNumber, 2>;
    return guarded([&]() -> Outcome<Halo> {
        const PartLayout& layout = parts.layout;
        std::vector<Buffer<RowRequest<Ends>>> requests(ranks.size());
        for (std::uint32_t b = 0; b < parts.own.size(); ++b) {
            const RingedPart<D>& part = parts.own[b];
            for (std::uint32_t e = 0; e < edges[b].size(); ++e) {
                const auto& ends = edges[b].vertices[e];
                if (part.owns(ends)) continue;
                const Ends numbers{part.vertices[ends[0]], part.vertices[ends[1]]};
                const std::size_t owner = layout.part_with(numbers[0]);
                requests[layout.rank_of(owner)].push_back({numbers, owner, {b, e}});
            }
        }
        return halo_of<Ends>(std::move(requests), layout, ranks, [&](std::uint32_t b, const Ends& numbers) {
            const RingedPart<D>& part = parts.own[b];
            const auto local = [&](GlobalNumber number) {
                return VertexId(std::ranges::lower_bound(part.vertices, number) - part.vertices.begin());
            };
            return find_edge(edges[b], local(numbers[0]), local(numbers[1])).value;
        });
    });
}

template <int D>
BetweenRingedParts<D>::BetweenRingedParts(Ranks& ranks, const Halo& halo, std::size_t parts)
    : ranks_(ranks), halo_(halo), sent_(parts) {
    for (std::uint32_t r = 0; r < halo.send.size(); ++r)
        for (std::uint32_t i = 0; i < halo.send[r].size(); ++i)
            sent_[halo.send[r][i].part].push_back({halo.send[r][i].row, r, i});
    for (auto& rows : sent_) std::ranges::sort(rows, {}, &SentRow::row);
}

template <int D>
Outcome<std::vector<double>> BetweenRingedParts<D>::gather(Outcome<std::vector<double>> of_parts) {
    return gather_all<double>(ranks_, of_parts);
}

template <int D>
std::vector<EdgeId> BetweenRingedParts<D>::shared(std::size_t part, std::vector<EdgeId> edges) const {
    std::erase_if(edges,
                  [&](EdgeId e) { return !std::ranges::binary_search(sent_[part], e.value, {}, &SentRow::row); });
    return edges;
}

template <int D>
Outcome<EdgesOfParts> BetweenRingedParts<D>::exchange_rows(std::span<const std::span<Vec<D>>> rows,
                                                           const EdgesOfParts& edges) {
    struct Sent {
        std::uint64_t at = 0;
        Vec<D> row;
    };
    std::vector<std::vector<Sent>> of_ranks(ranks_.size());
    for (std::size_t b = 0; b < sent_.size(); ++b)
        for (const EdgeId e : edges[b])
            for (const SentRow& sent_row : std::ranges::equal_range(sent_[b], e.value, {}, &SentRow::row))
                of_ranks[sent_row.rank].push_back({sent_row.at, rows[b][e.index()]});
    std::vector<Bytes> to;
    for (auto& sent : of_ranks) {
        to.push_back(bytes_of<Sent>(sent));
        sent = {};
    }
    const auto from = ranks_.exchange(std::move(to));
    if (!from) return fail(from.error());
    EdgesOfParts updated(sent_.size());
    for (std::size_t r = 0; r < from->size(); ++r) {
        std::vector<Sent> received;
        append_values((*from)[r], received);
        for (const Sent& sent : received) {
            const Halo::Row& into = halo_.get[r][sent.at];
            rows[into.part][into.row] = sent.row;
            updated[into.part].emplace_back(into.row);
        }
    }
    for (auto& some : updated) std::ranges::sort(some);
    return updated;
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template Outcome<Halo> vertex_halo<D>(const RingedParts<D>&, Ranks&);                            \
    template Outcome<Halo> edge_halo<D>(const RingedParts<D>&, std::span<const EdgeSet<D>>, Ranks&); \
    template class BetweenRingedParts<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
