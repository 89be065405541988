module;
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.distributed;
import camber.io;
import :written_together;

namespace camber::app {

namespace {

/// The draft on this rank, of which the first rank tells the name.
Outcome<SharedFile> opened(Ranks& ranks, const std::string& path, std::uint64_t bytes, const Outcome<Done>& can_begin) {
    std::optional<Outcome<SharedFile>> first;
    Outcome<std::string> draft = std::string();
    if (!can_begin) draft = fail(can_begin.error());
    if (can_begin && ranks.rank() == 0) {
        first = SharedFile::make(path, bytes);
        draft = *first ? Outcome<std::string>((*first)->draft()) : fail(first->error());
    }
    draft = told_by_first(ranks, draft);
    if (!draft) return fail(std::move(draft.error()));
    return first ? std::move(*first) : SharedFile::join(path, *draft);
}

Outcome<Done> put(const Outcome<SharedFile>& file, std::span<const FilePiece> pieces, const Execution& execution) {
    if (!file) return fail(file.error());
    for (const FilePiece& piece : pieces)
        if (auto written = file->write(piece.offset, piece.bytes, execution); !written) return written;
    return Done{};
}

/// When all have written theirs it has its name.
Outcome<Done> finished(Ranks& ranks, Outcome<SharedFile>& file, const Outcome<Done>& written) {
    if (auto all = agreed(ranks, written ? file->flush() : written); !all) return all;
    return agreed(ranks, ranks.rank() == 0 ? file->publish() : Outcome<Done>(Done{}));
}

}  // namespace

Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                             const Outcome<std::span<const FilePiece>>& pieces, const Execution& execution) {
    auto file = opened(ranks, path, bytes, pieces ? Outcome<Done>(Done{}) : fail(pieces.error()));
    if (!file) return fail(file.error());
    return finished(ranks, file, put(file, *pieces, execution));
}

Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes, std::size_t turns,
                             const std::function<Outcome<std::vector<FilePiece>>(std::size_t)>& pieces_of,
                             const Execution& execution) {
    auto file = opened(ranks, path, bytes, Done{});
    if (!file) return fail(file.error());
    Outcome<Done> written{Done{}};
    for (std::size_t turn = 0; turn < turns && written; ++turn) {
        const auto pieces = pieces_of(turn);
        written = pieces ? put(file, *pieces, execution) : fail(pieces.error());
        report_progress(execution, turn + 1, turns);
    }
    return finished(ranks, file, written);
}

}  // namespace camber::app
