module;
#include <cstddef>
#include <span>
#include <utility>
export module camber.operation:vertex_data;
import camber.core;
import camber.metric;
import camber.surface;

export namespace camber {

/// The metric at a vertex, as it is given and ready to measure with, and where in the back mesh that is.
template <int D>
struct VertexMetric {
    LogMetric<D> log_metric;
    MeasuringMetric<D> measure;
    ElementId back;

    VertexMetric() = default;
    VertexMetric(const LogMetric<D>& given, ElementId at) : log_metric(given), measure(given), back(at) {}
    friend bool operator==(const VertexMetric&, const VertexMetric&) = default;
};

/// All that is known of one vertex beside its point, its reference and where it lies in the mesh.
template <int D>
struct VertexRow {
    VertexMetric<D> metric;
    GeometryPlace place;
    LogGradient<D> gradient{};
};

/// The same of all vertices: a row each in every column that has any. A new kind of data is a new column here, and goes
/// along with every commit.
template <int D>
struct VertexData {
    Column<VertexMetric<D>> metrics;
    /// What the vertex lies on, and where in that if it is at a place of the geometry's; of nothing inside. No rows
    /// without a geometry.
    Column<GeometryPlace> places = {};
    Column<LogGradient<D>> gradients = {};  ///< of degree 2: of the field, recovered

    /// What is known to lie there; of nothing, where nothing is known.
    [[nodiscard]] GeometryPlace place(VertexId v) const { return places.empty() ? GeometryPlace{} : places[v]; }
    [[nodiscard]] VertexRow<D> row(VertexId v) const {
        return {metrics[v], place(v), gradients.empty() ? LogGradient<D>{} : gradients[v]};
    }
    /// rows[i] of ids[i], of so many vertices now.
    void put(std::span<const VertexId> ids, std::span<const VertexRow<D>> rows, std::size_t vertices) {
        put_column(metrics, ids, vertices, [&](std::size_t i) { return rows[i].metric; });
        if (!places.empty()) put_column(places, ids, vertices, [&](std::size_t i) { return rows[i].place; });
        if (!gradients.empty()) put_column(gradients, ids, vertices, [&](std::size_t i) { return rows[i].gradient; });
    }

  private:
    template <class T, class Of>
    static void put_column(Column<T>& column, std::span<const VertexId> ids, std::size_t vertices, Of&& of) {
        auto values = take(std::move(column));
        values.resize(vertices);
        for (std::size_t i = 0; i < ids.size(); ++i) values[ids[i].index()] = of(i);
        column = std::move(values);
    }
};

}  // namespace camber
