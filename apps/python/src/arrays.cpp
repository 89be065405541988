#include "python.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

import camber.core;
import camber.io;
import camber.recipes;
import camber.reports;
import camber.transfer;

namespace camber::python {

namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

Column<double> packed(const Doubles& matrices, std::size_t n) {
    const auto rows = static_cast<std::size_t>(matrices.shape(0));
    Buffer<double> out;
    out.reserve(rows * n * (n + 1) / 2);
    const double* m = matrices.data();
    for (std::size_t r = 0; r < rows; ++r, m += n * n)
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j) out.push_back(0.5 * (m[i * n + j] + m[j * n + i]));
    return Column<double>(std::move(out));
}

py::array unpacked(const Column<double>& values, std::size_t n) {
    const std::size_t width = n * (n + 1) / 2, rows = values.size() / width;
    py::array_t<double> out({rows, n, n});
    double* m = out.mutable_data();
    for (std::size_t r = 0; r < rows; ++r, m += n * n)
        for (std::size_t i = 0, k = r * width; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j, ++k) m[i * n + j] = m[j * n + i] = values[k];
    return read_only(std::move(out));
}

/// Index of the first matrix that is not symmetric: two opposite entries differ by more than `rounding` times its
/// largest entry.
std::optional<std::size_t> first_asymmetric(const Doubles& matrices, std::size_t n, double rounding) {
    const double* m = matrices.data();
    for (py::ssize_t r = 0; r < matrices.shape(0); ++r, m += n * n) {
        double largest = 0, difference = 0;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j) {
                largest = std::max(largest, std::abs(m[i * n + j]));
                difference = std::max(difference, std::abs(m[i * n + j] - m[j * n + i]));
            }
        if (difference > rounding * largest) return static_cast<std::size_t>(r);
    }
    return std::nullopt;
}

Doubles doubles_of(const py::handle& value, const std::string& name) {
    const auto array = py::array::ensure(value);
    const char kind = array ? array.dtype().kind() : 'O';
    if (std::string_view("fiub").find(kind) == std::string_view::npos) {
        PyErr_Clear();
        raise({ErrorKind::input, "is not an array of numbers", name, {}, "give floats"});
    }
    return py::reinterpret_borrow<Doubles>(Doubles::ensure(array));
}

[[noreturn]] void refuse(const std::string& name, const py::array& array, const std::string& expected) {
    std::string shape;
    for (py::ssize_t d = 0; d < array.ndim(); ++d) shape += (d > 0 ? ", " : "") + std::to_string(array.shape(d));
    raise({ErrorKind::input, "has the shape (" + shape + ")", name, {}, expected});
}

std::optional<FieldKind> kind_of(const Doubles& array, std::size_t n) {
    const auto wide = [&](py::ssize_t d) { return static_cast<std::size_t>(array.shape(d)); };
    if (array.ndim() == 1 || (array.ndim() == 2 && wide(1) == 1)) return FieldKind::scalar;
    if (array.ndim() == 2 && wide(1) == n) return FieldKind::vector;
    if (array.ndim() == 3 && wide(1) == n && wide(2) == n)
        return first_asymmetric(array, n, 1e-12) ? FieldKind::full_tensor : FieldKind::symmetric_tensor;
    return std::nullopt;
}

/// True if neither the array nor any array whose memory it uses is writeable.
bool is_immutable(const py::array& array) {
    py::object at = array;
    while (py::isinstance<py::array>(at)) {
        if (py::reinterpret_borrow<py::array>(at).writeable()) return false;
        at = at.attr("base");
    }
    return at.is_none() || py::isinstance<py::capsule>(at) || py::isinstance<py::bytes>(at);
}

}  // namespace

py::array read_only(py::array array) {
    const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
    const std::vector<py::ssize_t> strides(array.strides(), array.strides() + array.ndim());
    const py::capsule owner(new py::array(array),
                            [](void* owned_array) { delete static_cast<py::array*>(owned_array); });
    py::array view(array.dtype(), shape, strides, array.data(), owner);
    py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
    return view;
}

std::shared_ptr<const void> owner_of(const py::array& array) {
    if (!is_immutable(array)) return nullptr;
    return {new py::array(array), [](const void* owned_array) {
                const py::gil_scoped_acquire locked;
                delete static_cast<const py::array*>(owned_array);
            }};
}

py::dict arrays_of(const std::vector<run::NamedField>& fields, int dimension) {
    const auto n = static_cast<std::size_t>(dimension);
    py::dict out;
    for (const run::NamedField& field : fields) {
        const Column<double>& values = field.field.values;
        switch (field.kind) {
            case FieldKind::scalar: out[py::str(field.name)] = view_of<double>(values, 0); break;
            case FieldKind::vector: {
                const auto rows = static_cast<py::ssize_t>(values.size() / n);
                out[py::str(field.name)] = view_of<double>(values, 0).reshape({rows, static_cast<py::ssize_t>(n)});
                break;
            }
            case FieldKind::symmetric_tensor: out[py::str(field.name)] = unpacked(values, n); break;
            case FieldKind::full_tensor: {
                const auto rows = static_cast<py::ssize_t>(values.size() / (n * n)), m = static_cast<py::ssize_t>(n);
                out[py::str(field.name)] = view_of<double>(values, 0).reshape({rows, m, m});
                break;
            }
        }
    }
    return out;
}

std::vector<run::NamedField> fields_of(const py::dict& fields, int dimension, std::size_t vertices, std::size_t nodes) {
    const auto n = static_cast<std::size_t>(dimension);
    const std::string d = std::to_string(dimension);
    std::vector<run::NamedField> out;
    for (const auto& [key, value] : fields) {
        const auto name = key.cast<std::string>();
        const Doubles array = doubles_of(value, name);
        const auto rows = array.ndim() > 0 ? static_cast<std::size_t>(array.shape(0)) : 0;
        const std::string expected = "give a row for each of the " + std::to_string(vertices) + " vertices" +
                                     (nodes > vertices ? " or " + std::to_string(nodes) + " nodes" : "") +
                                     ": (n,), of vectors (n, " + d + "), of tensors (n, " + d + ", " + d + ")";
        const auto kind = array.ndim() > 0 ? kind_of(array, n) : std::nullopt;
        if (!kind || (rows != vertices && rows != nodes)) refuse(name, array, expected);
        const bool is_packed = *kind == FieldKind::symmetric_tensor;
        out.push_back({name, *kind,
                       TransferField{values_per_vertex(*kind, dimension), rows == vertices ? 1 : 2,
                                     is_packed ? packed(array, n) : column_of<double>(array)}});
    }
    return out;
}

Solution metric_of(const py::array& specified, int dimension, const std::string& name) {
    constexpr double rounding = 1e-8;
    const auto n = static_cast<std::size_t>(dimension);
    const std::string d = std::to_string(dimension);
    const Doubles array = doubles_of(specified, name);
    const auto rows = array.ndim() > 0 ? static_cast<std::size_t>(array.shape(0)) : 0;
    if (array.ndim() == 1) return {dimension, {FieldKind::scalar}, rows, column_of<double>(array)};
    const bool are_tensors = array.ndim() == 3 && static_cast<std::size_t>(array.shape(1)) == n &&
                             static_cast<std::size_t>(array.shape(2)) == n;
    if (!are_tensors)
        refuse(name, array, "give sizes (n,) or symmetric matrices (n, " + d + ", " + d + "), a row a vertex");
    if (const auto row = first_asymmetric(array, n, rounding))
        raise({ErrorKind::input, "is not symmetric", name, Entity{"row", *row}, "a metric is M = (M + Mᵀ) / 2"});
    return {dimension, {FieldKind::symmetric_tensor}, rows, packed(array, n)};
}

py::array array_of(const Solution& metric) {
    if (metric.fields.front() == FieldKind::scalar) return view_of<double>(metric.values, 0);
    return unpacked(metric.values, static_cast<std::size_t>(metric.dimension));
}

}  // namespace camber::python
