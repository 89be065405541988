module;
#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>
module camber.mpi;
import camber.core;
import camber.distributed;

namespace camber {

namespace {

/// Value sent in place of a message size if the sender has an error.
constexpr std::int64_t failed = -1;

class MpiRanks final : public Ranks {
  public:
    MpiRanks(int& argc, char**& argv, MpiOptions options) : options_(options) {
        int threads = 0;
        MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &threads);
        MPI_Comm_dup(MPI_COMM_WORLD, &ranks_);
        MPI_Comm_rank(ranks_, &rank_);
        MPI_Comm_size(ranks_, &size_);
    }
    MpiRanks(const MpiRanks&) = delete;
    MpiRanks(MpiRanks&&) = delete;
    MpiRanks& operator=(const MpiRanks&) = delete;
    MpiRanks& operator=(MpiRanks&&) = delete;
    ~MpiRanks() override {
        MPI_Comm_free(&ranks_);
        MPI_Finalize();
    }

    [[nodiscard]] std::size_t rank() const override { return static_cast<std::size_t>(rank_); }
    [[nodiscard]] std::size_t size() const override { return static_cast<std::size_t>(size_); }
    [[nodiscard]] Traffic traffic() const override { return traffic_; }

  private:
    [[nodiscard]] Outcome<std::vector<Bytes>> exchanged(Outcome<std::vector<Bytes>> to) override {
        if (fatal_error_) return fail(*fatal_error_);
        if (to && to->size() != size())
            to = fail(ErrorKind::internal, "there is not one message for each rank in an exchange");
        ++traffic_.rounds;
        std::vector<std::int64_t> sizes(size(), failed), coming(size());
        if (to) std::ranges::transform(*to, sizes.begin(), [](const Bytes& b) { return std::int64_t(b.size()); });
        MPI_Alltoall(sizes.data(), 1, MPI_INT64_T, coming.data(), 1, MPI_INT64_T, ranks_);
        const auto first = std::ranges::find(coming, failed);
        if (first != coming.end()) {
            fatal_error_ = error_of(static_cast<int>(first - coming.begin()), to);
            return fail(*fatal_error_);
        }
        try {
            return moved(std::move(*to), coming);
        } catch (const std::exception& error) {  // reported below, because the other ranks already wait for messages of
                                                 // this one
            std::fprintf(stderr, "camber: rank %d of %d: %s in an exchange\n", rank_, size_, error.what());
            MPI_Abort(ranks_, 4);
        }
        return fail(ErrorKind::internal, "the ranks were to end");
    }

    /// Returns the error of rank `failing`, which is broadcast to all ranks.
    [[nodiscard]] Error error_of(int failing, const Outcome<std::vector<Bytes>>& own) {
        Bytes bytes;
        if (failing == rank_) bytes = packed(own.error());
        std::uint64_t size = bytes.size();
        MPI_Bcast(&size, 1, MPI_UINT64_T, failing, ranks_);
        bytes.resize(size);
        MPI_Bcast(bytes.data(), static_cast<int>(size), MPI_BYTE, failing, ranks_);
        return unpacked_error(bytes);
    }

    template <class Begin>
    void in_pieces(std::size_t bytes, const Begin& begin) const {
        for (std::size_t at = 0; at < bytes; at += options_.largest_message)
            begin(at, static_cast<int>(std::min(options_.largest_message, bytes - at)));
    }

    /// Exchanges the messages. MPI preserves the order of messages between two ranks, so pieces need no tags.
    [[nodiscard]] std::vector<Bytes> moved(std::vector<Bytes> to, const std::vector<std::int64_t>& coming) {
        std::vector<Bytes> from(size());
        std::vector<MPI_Request> requests;
        for (std::size_t r = 0; r < size(); ++r)
            if (r != rank()) from[r].resize(static_cast<std::size_t>(coming[r]));
        from[rank()] = std::move(to[rank()]);
        for (std::size_t r = 0; r < size(); ++r) {
            if (r == rank()) continue;
            in_pieces(from[r].size(), [&](std::size_t at, int bytes) {
                MPI_Irecv(from[r].data() + at, bytes, MPI_BYTE, static_cast<int>(r), 0, ranks_,
                          &requests.emplace_back());
            });
        }
        for (std::size_t step = 1; step < size(); ++step) {  // each rank begins with another destination; otherwise all
                                                             // would send to rank 0 at once
            const std::size_t r = (rank() + step) % size();
            in_pieces(to[r].size(), [&](std::size_t at, int bytes) {
                MPI_Isend(to[r].data() + at, bytes, MPI_BYTE, static_cast<int>(r), 0, ranks_, &requests.emplace_back());
                ++traffic_.messages;
                traffic_.bytes += static_cast<std::size_t>(bytes);
            });
        }
        MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
        return from;
    }

    MpiOptions options_;
    MPI_Comm ranks_ = MPI_COMM_NULL;
    int rank_ = 0, size_ = 1;
    Traffic traffic_;
    std::optional<Error> fatal_error_;
};

}  // namespace

std::unique_ptr<Ranks> mpi_ranks(int& argc, char**& argv, MpiOptions options) {
    return std::make_unique<MpiRanks>(argc, argv, options);
}

}  // namespace camber
