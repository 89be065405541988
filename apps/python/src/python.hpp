#pragma once
// Declarations of the module camber._camber: exceptions, work on threads, numpy arrays, meshes.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

import camber.core;
import camber.app_shell;
import camber.commands;
import camber.io;
import camber.recipes;
import camber.reports;

namespace camber::python {

namespace py = pybind11;

// ---------------------------------------------------------------- errors and work

[[noreturn]] void raise(const Error& error);

template <class T>
T value_of(Outcome<T> outcome) {
    if (!outcome) raise(outcome.error());
    return std::move(*outcome);
}

/// Runs work on its own thread, which does not hold the lock of the interpreter. Meanwhile the calling thread handles
/// signals, reports the progress, and runs Python callbacks.
class BackgroundTask {
  public:
    /// `progress`: None or a function of stage and share (0 to 1); if it returns False, the work stops.
    explicit BackgroundTask(py::object progress) : progress_(std::move(progress)) {}

    /// Runs f(host) on another thread. Raises an exception of a Python callback (KeyboardInterrupt, `progress`) if
    /// there is one, else the error that f returned.
    template <class F>
    auto run(F&& f) {
        using Result = std::invoke_result_t<F, app::Host>;
        std::optional<Result> result;
        {
            const py::gil_scoped_release without_lock;
            const std::jthread worker([&] {
                result = guarded([&]() -> Result { return f(host()); });
                const std::scoped_lock lock(mutex_);
                done_ = true;
                changed_.notify_all();
            });
            look_after();
        }
        if (raised_) std::rethrow_exception(raised_);
        return value_of(std::move(*result));
    }

    /// Called by the work to run f on the calling thread with the interpreter's lock. Returns false if f raised; the
    /// work must then end.
    bool call(std::function<void()> f);

  private:
    app::Host host();
    void look_after();
    void visit_python();

    py::object progress_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool done_ = false;
    std::function<void()> pending_call_;
    std::optional<std::pair<std::string, double>> pending_progress_;
    std::stop_source stop_;
    std::exception_ptr raised_;
};

// ---------------------------------------------------------------- arrays

/// Read-only array that shares the memory of a column and keeps it alive. Rows have `width` numbers; 0: the array is
/// one-dimensional.
template <class Number, class T>
py::array view_of(const Column<T>& column, std::size_t width) {
    const auto rows = static_cast<py::ssize_t>(column.size());
    std::vector<py::ssize_t> shape{rows};
    if (width > 0) shape.push_back(static_cast<py::ssize_t>(width));
    const py::capsule owner(new Column<T>(column),
                            [](void* owned_array) { delete static_cast<Column<T>*>(owned_array); });
    py::array view(py::dtype::of<Number>(), shape, reinterpret_cast<const Number*>(column.data()), owner);
    py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
    return view;
}

py::array read_only(py::array array);

/// Owner that keeps an immutable array alive; any thread may release it. Null if the array may change, and so must be
/// copied.
std::shared_ptr<const void> owner_of(const py::array& array);

/// Column that shares the memory of the array if it is immutable, else copies it.
template <class T, class Number>
Column<T> column_of(const py::array_t<Number, py::array::c_style | py::array::forcecast>& array) {
    const auto count = static_cast<std::size_t>(array.size()) * sizeof(Number) / sizeof(T);
    const std::span<const T> items(reinterpret_cast<const T*>(array.data()), count);
    auto owner = owner_of(array);
    return owner ? Column<T>(items, std::move(owner)) : Column<T>(Buffer<T>(items.begin(), items.end()));
}

/// Returns a dictionary from names to values at nodes. The shape of values is (n,) for scalars, (n, D) for vectors, (n,
/// D, D) for tensors.
py::dict arrays_of(const std::vector<run::NamedField>& fields, int dimension);
/// Inverse of `arrays_of`. The number of rows must be `vertices` or `nodes`. Raises for other shapes.
std::vector<run::NamedField> fields_of(const py::dict& fields, int dimension, std::size_t vertices, std::size_t nodes);

/// Metric from an array of sizes (n,) or tensors (n, D, D). Raises for other shapes.
Solution metric_of(const py::array& rows, int dimension, const std::string& name);
py::array array_of(const Solution& metric);

// ---------------------------------------------------------------- meshes

struct MeshHandle {
    DecodedMesh value;
    /// For each node its number in the input, from 1, or 0 for a new node. Empty: the numbers are 1, 2, 3 …
    Column<std::uint32_t> input_numbers = {};

    [[nodiscard]] int dimension() const;
    [[nodiscard]] int degree() const;
    [[nodiscard]] std::size_t vertices() const;
    /// Number of vertices, plus that of edge nodes for degree 2.
    [[nodiscard]] std::size_t nodes() const;
};

/// Moves `node_numbers` to `input_numbers`, because messages must show the node numbers of the mesh.
[[nodiscard]] MeshHandle handle_of(DecodedMesh mesh);

void bind_mesh(py::module_& module);
void bind_verbs(py::module_& module);

}  // namespace camber::python
