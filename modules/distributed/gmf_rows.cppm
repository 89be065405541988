module;
#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>
export module camber.distributed:gmf_rows;
import camber.core;
import :rows;

export namespace camber {

/// Of the bytes of a binary .meshb of degree 1: each call decodes its own rows, and touches no other bytes.
/// `after_rows` is called when some have been read: bytes that are mapped may leave memory. Errors: input, unsupported
/// (io:gmf_runs).
template <int D>
[[nodiscard]] Outcome<std::unique_ptr<MeshRows<D>>> rows_of_gmf(Column<std::byte> bytes, std::string_view name,
                                                                std::function<void()> after_rows = {});

/// Of a mesh in memory, which is not copied.
template <int D>
[[nodiscard]] std::unique_ptr<MeshRows<D>> rows_of(LinearMesh<D> mesh);

}  // namespace camber
