module;
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
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
    return file->flush();
}

}  // namespace

Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                             const Outcome<std::span<const FilePiece>>& pieces, const Execution& execution) {
    auto file = opened(ranks, path, bytes, pieces ? Outcome<Done>(Done{}) : fail(pieces.error()));
    if (auto all = agreed(ranks, pieces ? put(file, *pieces, execution) : Outcome<Done>(Done{})); !all) return all;
    return agreed(ranks, ranks.rank() == 0 ? file->publish() : Outcome<Done>(Done{}));
}

}  // namespace camber::app
