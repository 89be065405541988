#pragma once
// camber._camber: errors as exceptions, work that Python waits for, numpy's arrays, meshes.
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

/// Raises the exception of camber.exceptions that an error is.
[[noreturn]] void raise(const Error& error);

/// The value, or its error raised.
template <class T>
T value_of(Outcome<T> outcome) {
    if (!outcome) raise(outcome.error());
    return std::move(*outcome);
}

/// Work in a thread of its own, without the interpreter's lock. Meanwhile the caller's thread looks after signals,
/// reports the progress, and runs functions of Python.
class Watched {
  public:
    /// `progress`: None, or called with the stage and its share; a False from it stops the work.
    explicit Watched(py::object progress) : progress_(std::move(progress)) {}

    /// f(host) in another thread. Raises what Python raised meanwhile (KeyboardInterrupt, from `progress`, from what
    /// was called), else the error.
    template <class F>
    auto run(F&& f) {
        using Result = std::invoke_result_t<F, app::Host>;
        std::optional<Result> made;
        {
            const py::gil_scoped_release without_lock;
            const std::jthread worker([&] {
                made = guarded([&]() -> Result { return f(host()); });
                const std::scoped_lock lock(mutex_);
                done_ = true;
                changed_.notify_all();
            });
            look_after();
        }
        if (raised_) std::rethrow_exception(raised_);
        return value_of(std::move(*made));
    }

    /// In the work's thread: f() with the interpreter's lock, in the caller's thread. False: it raised, and the work is
    /// to end.
    bool call(std::function<void()> f);

  private:
    app::Host host();
    void look_after();
    void visit_python();

    py::object progress_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool done_ = false;
    std::function<void()> asked_;  ///< to be called
    std::optional<std::pair<std::string, double>> told_;
    std::stop_source stop_;
    std::exception_ptr raised_;
};

// ---------------------------------------------------------------- arrays

/// A read-only view of rows of `width` numbers each (0: of one each, an array of one dimension), which keeps the column
/// alive.
template <class Number, class T>
py::array view_of(const Column<T>& column, std::size_t width) {
    const auto rows = static_cast<py::ssize_t>(column.size());
    std::vector<py::ssize_t> shape{rows};
    if (width > 0) shape.push_back(static_cast<py::ssize_t>(width));
    const py::capsule owner(new Column<T>(column), [](void* held) { delete static_cast<Column<T>*>(held); });
    py::array view(py::dtype::of<Number>(), shape, reinterpret_cast<const Number*>(column.data()), owner);
    py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
    return view;
}

/// The array, of which nobody can make one that is written to.
py::array read_only(py::array array);

/// Keeps an array that nobody can write to, until whichever thread lets go of it last; null: it is to be copied.
std::shared_ptr<const void> owner_of(const py::array& array);

/// An array's rows as a column: the array's own memory where nobody can write to it, else a copy.
template <class T, class Number>
Column<T> column_of(const py::array_t<Number, py::array::c_style | py::array::forcecast>& array) {
    const auto count = static_cast<std::size_t>(array.size()) * sizeof(Number) / sizeof(T);
    const std::span<const T> items(reinterpret_cast<const T*>(array.data()), count);
    auto owner = owner_of(array);
    return owner ? Column<T>(items, std::move(owner)) : Column<T>(Buffer<T>(items.begin(), items.end()));
}

/// {name: values of the nodes, a row each}: (n,), of vectors (n, D), of tensors (n, D, D).
py::dict arrays_of(const std::vector<run::NamedField>& fields, int dimension);
/// The same back. `vertices`: of the mesh; other rows are those of all nodes. Raises: a shape that is none of these.
std::vector<run::NamedField> fields_of(const py::dict& fields, int dimension, std::size_t vertices, std::size_t nodes);

/// A metric's rows: sizes (n,), or tensors (n, D, D). Raises as above.
Solution metric_of(const py::array& rows, int dimension, const std::string& name);
py::array array_of(const Solution& metric);

// ---------------------------------------------------------------- meshes

/// The value behind camber.Mesh: immutable.
struct MeshHandle {
    DecodedMesh value;
    /// Of each node the number, from 1, of the point that it was given as, 0: of none; empty: 1, 2, 3 …
    Column<std::uint32_t> given_as = {};

    [[nodiscard]] int dimension() const;
    [[nodiscard]] int degree() const;
    [[nodiscard]] std::size_t vertices() const;
    /// Vertices and, of degree 2, the edges' nodes.
    [[nodiscard]] std::size_t nodes() const;
};

/// Nodes are numbered as the mesh has them, whatever its file did.
[[nodiscard]] MeshHandle handle_of(DecodedMesh mesh);

void bind_mesh(py::module_& module);
void bind_verbs(py::module_& module);

}  // namespace camber::python
