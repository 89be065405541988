// Writes GMF files, whole or in parts.
module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace gmf {

Outcome<int> chosen_version(GmfOptions options, int least) {
    if (options.version == 0) return least;
    if (options.version < 2 || options.version > 4)
        return fail(ErrorKind::usage, "GMF version " + std::to_string(options.version) + " is not 2, 3 or 4");
    if (options.version < least)
        return fail(ErrorKind::usage, "the file does not fit GMF version " + std::to_string(options.version), {}, {},
                    "use version " + std::to_string(least));
    return options.version;
}

namespace {

template <class Sink, class Mesh>
Outcome<Chunks> written(Sink sink, const Mesh& mesh) {
    auto done = put_mesh(sink, mesh);
    if (!done) return fail(std::move(done.error()));
    return std::move(sink).finish();
}

template <class Mesh>
Outcome<Chunks> encode(const Mesh& mesh, GmfOptions options, const Execution& execution) {
    BinarySizer sizer;
    if (auto sized = put_mesh(sizer, mesh); !sized) return fail(std::move(sized.error()));
    const bool ascii = options.encoding == GmfEncoding::ascii;
    const auto version = chosen_version(options, ascii ? 2 : sizer.min_version());
    if (!version) return fail(version.error());
    const std::size_t words = sizer.words();
    if (ascii) return written(AsciiWriter(*version, words, execution), mesh);
    return with_written_layout(*version, [&](auto layout) {
        return written(BinaryWriter<decltype(layout)>(*version, words, execution), mesh);
    });
}

template <int D>
bool are_columns_sound(const LinearMesh<D>& mesh) {
    return mesh.point_references.size() == mesh.points.size() &&
           mesh.elements.references.size() == mesh.elements.size() &&
           mesh.facets.references.size() == mesh.facets.size() && mesh.edges.references.size() == mesh.edges.size();
}

auto broken() { return fail(ErrorKind::internal, "the columns of the mesh have inconsistent lengths"); }

}  // namespace

}  // namespace gmf

template <int D>
Outcome<Chunks> encode_gmf_mesh(const Mesh<D>& mesh, GmfOptions options, const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) -> Outcome<Chunks> {
        const Grid<std::remove_cvref_t<decltype(simplices)>> grid{simplices};
        if (!gmf::are_columns_sound(grid.linear()) || !grid.is_sound()) return gmf::broken();
        return guarded([&] { return gmf::encode(simplices, options, execution); });
    });
}

template <int D>
std::vector<Notice> not_in_gmf(const Mesh<D>& all) {
    const LinearMesh<D> mesh = straight_simplices(all);
    std::size_t no_parameters = 0, no_distance = 0;
    const auto count = [&](const auto& associations) {
        for (const auto& on : associations)
            if (!gmf::is_in_gmf(on))
                ++no_parameters;
            else if (!on.distance)
                ++no_distance;
    };
    count(mesh.geometry.on_curves);
    count(mesh.geometry.on_surfaces);
    std::vector<Notice> losses = unsupported_data(
        mesh, {.associations = true, .corners = true, .ridges = true, .required = true, .directions = true}, "GMF");
    if (no_parameters > 0)
        losses.push_back({"GMF has no place for " + std::to_string(no_parameters) +
                              " associations with curves and surfaces whose parameters are not known",
                          true});
    if (no_distance > 0)
        losses.push_back({"GMF cannot mark distances from curves and surfaces as unknown: " +
                              std::to_string(no_distance) + " are written as 0",
                          true});
    return losses;
}

namespace gmf {

namespace {

/// Writes the file without the rows of points and simplices, for which it leaves gaps.
template <class LayoutType>
class FrameWriter : public BinaryWriter<LayoutType> {
  public:
    using Base = BinaryWriter<LayoutType>;

    FrameWriter(int version, const Execution& execution) : Base(version, 0, execution) {}

    template <class RowType>
    Outcome<Done> room(Keyword keyword, std::size_t n, std::uint64_t& start) {
        if (n == 0 && keyword != Keyword::vertices) return Done{};
        const std::size_t bytes = n * stride<RowType, LayoutType>;
        Base::begin_rows(keyword, n, bytes);
        start = Base::position();
        cut();
        Base::skip(bytes);
        begin_ = Base::position();
        return Done{};
    }
    [[nodiscard]] std::vector<FilePiece> finish() && {
        Base::end();
        cut();
        return std::move(pieces_);
    }

  private:
    void cut() {
        FilePiece piece{begin_, Buffer<std::byte>(Base::position() - begin_)};
        std::size_t at = 0;
        for (const auto& chunk : Base::take_chunks()) {
            if (!chunk.empty()) std::memcpy(piece.bytes.data() + at, chunk.data(), chunk.size());
            at += chunk.size();
        }
        pieces_.push_back(std::move(piece));
    }

    std::uint64_t begin_ = 0;
    std::vector<FilePiece> pieces_;
};

class FrameSizer : public BinarySizer {
  public:
    template <class RowType>
    Outcome<Done> room(Keyword keyword, std::size_t n, std::uint64_t&) {
        return rows<RowType>(keyword, n, 0);
    }
};

template <int D, int Degree, class Sink>
Outcome<Done> put_frame(Sink& sink, const LinearMesh<D>& lists, GmfFrame& frame) {
    const PartTotals& totals = frame.totals;
    const auto simplices = [&]<int K>(std::integral_constant<int, K>, std::size_t n, std::uint64_t& start) {
        return sink.template room<SimplexRow<nodes_of_degree<K, Degree>>>(simplex_keyword<K, Degree>, n, start);
    };
    return sink.value(Keyword::dimension, D)
        .and_then([&](Done) {
            return sink.template room<VertexRow<D>>(Keyword::vertices, totals.vertices + totals.mid_nodes,
                                                    frame.points);
        })
        .and_then([&](Done) { return simplices(std::integral_constant<int, D>(), totals.elements, frame.elements); })
        .and_then([&](Done) { return simplices(std::integral_constant<int, D - 1>(), totals.facets, frame.facets); })
        .and_then([&](Done) -> Outcome<Done> {
            if constexpr (D == 3) return simplices(std::integral_constant<int, 1>(), totals.edges, frame.edges);
            return Done{};
        })
        .and_then([&](Done) { return put_features(sink, lists); });
}

template <int D, int Degree>
Outcome<std::vector<FilePiece>> written_frame(GmfFrame& frame, const LinearMesh<D>& lists, const Execution& execution) {
    return with_written_layout(frame.version, [&](auto layout) -> Outcome<std::vector<FilePiece>> {
        FrameWriter<decltype(layout)> writer(frame.version, execution);
        if (auto put = put_frame<D, Degree>(writer, lists, frame); !put) return fail(std::move(put.error()));
        auto pieces = std::move(writer).finish();
        frame.bytes = pieces.back().offset + pieces.back().bytes.size();
        return pieces;
    });
}

/// Encodes n rows of a block. `first` is the number of the first of these rows, and row(i) returns row `first` + i.
/// `start` is the byte at which row 0 of the block begins.
template <class RowType, class LayoutType>
Outcome<FilePiece> piece_of(std::uint64_t start, std::uint64_t first, std::size_t n, const Execution& execution,
                            const auto& row) {
    constexpr std::size_t step = stride<RowType, LayoutType>;
    FilePiece piece{start + first * step, Buffer<std::byte>(n * step)};
    auto done = each_chunk(
        execution, n,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) store_row<LayoutType>(row(i), piece.bytes.data() + i * step);
        },
        8192);
    if (!done) return fail(std::move(done.error()));
    return piece;
}

template <class LayoutType, int D>
Outcome<FilePiece> piece_of_points(const PointRun<D>& run, std::uint64_t start, std::uint64_t before,
                                   const Execution& execution) {
    return piece_of<VertexRow<D>, LayoutType>(
        start, before + run.first, run.points.size(), execution,
        [&](std::size_t i) { return VertexRow<D>{{run.references[i]}, run.points[i].c}; });
}

template <class LayoutType, int K, int Degree>
Outcome<FilePiece> piece_of_simplices(const SimplexRun<K, Degree>& run, std::uint64_t start,
                                      const Execution& execution) {
    constexpr int nodes = nodes_of_degree<K, Degree>;
    return piece_of<SimplexRow<nodes>, LayoutType>(start, run.first, run.nodes.size(), execution, [&](std::size_t i) {
        SimplexRow<nodes> row;
        for (int n = 0; n < nodes; ++n) row.integer[n] = to_file(run.nodes[i][n]);
        row.integer[nodes] = run.references[i];
        return row;
    });
}

template <class LayoutType, int D, int Degree>
Outcome<std::vector<FilePiece>> pieces_of_part(const GmfFrame& frame, const FilePart<D, Degree>& part,
                                               const Execution& execution) {
    std::vector<FilePiece> pieces;
    const auto add = [&](Outcome<FilePiece> piece) -> Outcome<Done> {
        if (!piece) return fail(std::move(piece.error()));
        if (!piece->bytes.empty()) pieces.push_back(std::move(*piece));
        return Done{};
    };
    auto done = add(piece_of_points<LayoutType>(part.vertices, frame.points, 0, execution));
    if (done) done = add(piece_of_points<LayoutType>(part.mid_nodes, frame.points, frame.totals.vertices, execution));
    if (done) done = add(piece_of_simplices<LayoutType>(part.elements, frame.elements, execution));
    if (done) done = add(piece_of_simplices<LayoutType>(part.facets, frame.facets, execution));
    if (done && D == 3) done = add(piece_of_simplices<LayoutType>(part.edges, frame.edges, execution));
    if (!done) return fail(std::move(done.error()));
    return pieces;
}

}  // namespace

}  // namespace gmf

template <int D, int Degree>
Outcome<GmfFrame> gmf_frame(const PartTotals& totals, const LinearMesh<D>& lists, int version) {
    return guarded([&]() -> Outcome<GmfFrame> {
        GmfFrame frame{.totals = totals};
        gmf::FrameSizer sizer;
        if (auto sized = gmf::put_frame<D, Degree>(sizer, lists, frame); !sized) return fail(std::move(sized.error()));
        const auto chosen = gmf::chosen_version({.version = version}, sizer.min_version());
        if (!chosen) return fail(chosen.error());
        frame.version = *chosen;
        if (auto written = gmf::written_frame<D, Degree>(frame, lists, {}); !written)
            return fail(std::move(written.error()));
        return frame;
    });
}

template <int D, int Degree>
Outcome<std::vector<FilePiece>> encode_gmf_frame(const GmfFrame& frame, const LinearMesh<D>& lists,
                                                 const Execution& execution) {
    return guarded([&] {
        GmfFrame again = frame;
        return gmf::written_frame<D, Degree>(again, lists, execution);
    });
}

template <int D, int Degree>
Outcome<std::vector<FilePiece>> encode_gmf_part(const GmfFrame& frame, const FilePart<D, Degree>& part,
                                                const Execution& execution) {
    return guarded([&] {
        return gmf::with_written_layout(
            frame.version, [&](auto layout) { return gmf::pieces_of_part<decltype(layout)>(frame, part, execution); });
    });
}

#define CAMBER_INSTANTIATE(D, DEGREE)                                                                                \
    template Outcome<GmfFrame> gmf_frame<D, DEGREE>(const PartTotals&, const LinearMesh<D>&, int);                   \
    template Outcome<std::vector<FilePiece>> encode_gmf_frame<D, DEGREE>(const GmfFrame&, const LinearMesh<D>&,      \
                                                                         const Execution&);                          \
    template Outcome<std::vector<FilePiece>> encode_gmf_part<D, DEGREE>(const GmfFrame&, const FilePart<D, DEGREE>&, \
                                                                        const Execution&);

CAMBER_INSTANTIATE(2, 1)
CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 1)
CAMBER_INSTANTIATE(3, 2)
#undef CAMBER_INSTANTIATE

#define CAMBER_INSTANTIATE(D)                                   \
    template std::vector<Notice> not_in_gmf<D>(const Mesh<D>&); \
    template Outcome<Chunks> encode_gmf_mesh<D>(const Mesh<D>&, GmfOptions, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
