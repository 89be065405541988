#pragma once
// Columns as numpy's arrays, and arrays as columns.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.io;
import camber.recipes;
import camber.reports;

namespace camber::python {

namespace py = pybind11;

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

}  // namespace camber::python
