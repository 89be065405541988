// Reads a mesh in runs of rows, one for each rank, and writes it again: `mpirun -n N test_mpi_files copy IN.meshb
// OUT.meshb`. With `killed` instead of `copy` the last rank is killed in between, with `failing` it returns an error.
#include <array>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

import camber.core;
import camber.io;
import camber.distributed;
import camber.mpi;
import camber.app_shell;
import camber.commands;

namespace {

using namespace camber;

struct Run {
    std::size_t begin, end;
};
Run run_of(const Ranks& ranks, std::size_t rows) {
    return {rows * ranks.rank() / ranks.size(), rows * (ranks.rank() + 1) / ranks.size()};
}

template <int K>
SimplexRun<K, 1> simplex_run(std::size_t begin, const SimplexRows<K>& rows) {
    SimplexRun<K, 1> run{begin, {}, rows.references};
    for (const auto& simplex : rows.vertices) {
        std::array<std::uint64_t, K + 1> nodes{};
        for (std::size_t n = 0; n <= K; ++n) nodes[n] = simplex[n].value;
        run.nodes.push_back(nodes);
    }
    return run;
}

/// The rows of this rank.
Outcome<FilePart<3, 1>> part_of(const Ranks& ranks, const MeshRows<3>& rows) {
    const RowCounts counts = rows.counts();
    const Run v = run_of(ranks, counts.points), e = run_of(ranks, counts.elements), f = run_of(ranks, counts.facets),
              l = run_of(ranks, counts.edges);
    auto points = rows.points(v.begin, v.end);
    const auto elements = rows.elements(e.begin, e.end);
    const auto facets = rows.facets(f.begin, f.end);
    const auto edges = rows.edges(l.begin, l.end);
    if (!points) return fail(points.error());
    if (!elements) return fail(elements.error());
    if (!facets) return fail(facets.error());
    if (!edges) return fail(edges.error());
    FilePart<3, 1> part;
    part.vertices = {v.begin, std::move(points->points), std::move(points->references)};
    part.elements = simplex_run<3>(e.begin, *elements);
    part.facets = simplex_run<2>(f.begin, *facets);
    part.edges = simplex_run<1>(l.begin, *edges);
    return part;
}

struct Pieces {
    GmfFrame frame;
    std::vector<FilePiece> pieces;
};

Outcome<Pieces> pieces_of(const Ranks& ranks, const std::string& path) {
    const auto bytes = app::map_file(path);
    if (!bytes) return fail(bytes.error());
    const auto rows = rows_of_gmf<3>(*bytes, path);
    if (!rows) return fail(rows.error());
    const RowCounts counts = (*rows)->counts();
    const auto lists = (*rows)->lists();
    if (!lists) return fail(lists.error());
    const auto part = part_of(ranks, **rows);
    if (!part) return fail(part.error());
    const auto frame = gmf_frame<3, 1>(
        {.vertices = counts.points, .elements = counts.elements, .facets = counts.facets, .edges = counts.edges},
        *lists);
    if (!frame) return fail(frame.error());
    auto pieces = encode_gmf_part(*frame, *part, {});
    if (!pieces) return fail(pieces.error());
    if (ranks.rank() > 0) return Pieces{*frame, std::move(*pieces)};
    auto frame_pieces = encode_gmf_frame<3, 1>(*frame, *lists, {});
    if (!frame_pieces) return fail(frame_pieces.error());
    for (FilePiece& piece : *frame_pieces) pieces->push_back(std::move(piece));
    return Pieces{*frame, std::move(*pieces)};
}

/// Kills the last rank after the draft file exists, while the others wait for it.
Outcome<Done> wait_for_the_last(Ranks& ranks, const std::string& path) {
    auto file = ranks.rank() == 0 ? app::SharedFile::make(path, 8) : Outcome<app::SharedFile>(fail({}));
    const auto draft = broadcast_from_first(ranks, file ? Outcome<std::string>(file->draft()) : std::string());
    if (!draft) return fail(draft.error());
    if (ranks.rank() + 1 == ranks.size()) std::raise(SIGKILL);
    return agreed(ranks, Outcome<Done>(Done{}));
}

}  // namespace

int main(int argc, char** argv) {
    [[maybe_unused]] const auto stop = app::stop_on_signals();
    const auto ranks = mpi_ranks(argc, argv);
    if (argc != 4) return 2;
    const std::string_view mode = argv[1];
    const bool is_last = ranks->rank() + 1 == ranks->size();
    if (mode == "killed")
        if (const auto status = wait_for_the_last(*ranks, argv[3]); !status) return 3;
    auto result = pieces_of(*ranks, argv[2]);
    if (mode == "failing" && is_last) result = fail(ErrorKind::input, "is damaged", argv[2]);
    const auto pieces =
        result ? Outcome<std::span<const FilePiece>>(std::span<const FilePiece>(result->pieces)) : fail(result.error());
    const auto status = app::write_together(*ranks, argv[3], result ? result->frame.bytes : 0, pieces, {});
    if (status) return 0;
    if (ranks->rank() == 0) std::fprintf(stderr, "camber: %s\n", describe(status.error()).c_str());
    return 3;
}
