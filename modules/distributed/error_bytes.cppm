export module camber.distributed:error_bytes;
import camber.core;
import :ranks;

export namespace camber {

/// An error for another process, and back.
[[nodiscard]] Bytes packed(const Error& error);
[[nodiscard]] Error unpacked_error(const Bytes& bytes);

}  // namespace camber
