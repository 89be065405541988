module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.box_tree;
import :parts;

namespace camber {

namespace {

/// Samples each way in a cell, and by which share of it the box of the samples is less than that of the cell.
constexpr std::size_t samples = 4;
constexpr double between_samples = 0.1;

Box<3> widened(Box<3> box) {
    const double by = between_samples * box.diagonal();
    for (std::size_t k = 0; k < 3; ++k) {
        box.low[k] -= by;
        box.high[k] += by;
    }
    return box;
}

Cells finished(std::vector<Cell> cells, const std::vector<Box<3>>& boxes) {
    Cells out;
    out.boxes.reserve(boxes.size());
    for (const Box<3>& box : boxes) {
        out.bounds.include(box);
        out.boxes.push_back(widened(box));
        out.reach.include(out.boxes.back());
    }
    out.cells = std::move(cells);
    out.tree = BoxTree<3>(out.boxes);
    return out;
}

/// Around points of a cell, along a surface's tangent plane in the middle of it.
OrientedBox oriented_box(const std::vector<Vec<3>>& points, const occ::SurfaceJet& middle) {
    constexpr double around = 0.1;
    OrientedBox box;
    const Vec<3> u = vec(middle.u), normal = cross(u, vec(middle.v));
    if (!(norm(u) > 0) || !(norm(normal) > 0)) {
        for (std::size_t k = 0; k < 3; ++k) box.axes[k][static_cast<int>(k)] = 1;
    } else {
        box.axes[0] = normalised(u);
        box.axes[2] = normalised(normal);
        box.axes[1] = cross(box.axes[2], box.axes[0]);
    }
    Box<3> along;
    for (const Vec<3>& p : points)
        along.include(Vec<3>{{dot(p, box.axes[0]), dot(p, box.axes[1]), dot(p, box.axes[2])}});
    const double thickness = along.high[2] - along.low[2];
    for (std::size_t k = 0; k < 3; ++k) {
        const int i = static_cast<int>(k);
        box.centre += 0.5 * (along.low[i] + along.high[i]) * box.axes[k];
        const double length = along.high[i] - along.low[i];
        const double more = k < 2 ? around * length + thickness : around * along.diagonal();
        box.half[k] = 0.5 * length + more;
    }
    return box;
}

double between(double low, double high, std::size_t i, std::size_t n) {
    return low + (high - low) * static_cast<double>(i) / static_cast<double>(n);
}

}  // namespace

Cells cells_of_face(const occ::Kernel& kernel, std::size_t face) {
    const occ::FaceFacts& facts = kernel.faces[face];
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    std::vector<OrientedBox> oriented;
    cells.reserve(facts.cells[0] * facts.cells[1]);
    boxes.reserve(cells.capacity());
    for (std::size_t i = 0; i < facts.cells[0]; ++i)
        for (std::size_t j = 0; j < facts.cells[1]; ++j) {
            Cell cell;
            for (std::size_t k = 0; k < 2; ++k) {
                const std::size_t at = k == 0 ? i : j;
                cell.low[k] = between(facts.low[k], facts.high[k], at, facts.cells[k]);
                cell.high[k] = between(facts.low[k], facts.high[k], at + 1, facts.cells[k]);
            }
            Box<3> box;
            std::vector<Vec<3>> points;
            occ::SurfaceJet middle{};
            for (std::size_t a = 0; a <= samples; ++a)
                for (std::size_t b = 0; b <= samples; ++b) {
                    const occ::SurfaceJet jet = kernel.on_surface(face, between(cell.low[0], cell.high[0], a, samples),
                                                                  between(cell.low[1], cell.high[1], b, samples));
                    points.push_back(vec(jet.point));
                    box.include(points.back());
                    if (2 * a == samples && 2 * b == samples) middle = jet;
                }
            cells.push_back(cell);
            boxes.push_back(box);
            oriented.push_back(oriented_box(points, middle));
        }
    Cells out = finished(std::move(cells), boxes);
    out.oriented = std::move(oriented);
    return out;
}

Cells cells_of_edge(const occ::Kernel& kernel, std::size_t edge) {
    const occ::EdgeFacts& facts = kernel.edges[edge];
    std::vector<Cell> cells;
    std::vector<Box<3>> boxes;
    cells.reserve(facts.cells);
    boxes.reserve(facts.cells);
    for (std::size_t i = 0; i < facts.cells; ++i) {
        Cell cell;
        cell.low[0] = between(facts.first, facts.last, i, facts.cells);
        cell.high[0] = between(facts.first, facts.last, i + 1, facts.cells);
        Box<3> box;
        for (std::size_t a = 0; a <= 2 * samples; ++a)
            box.include(vec(kernel.on_curve(edge, between(cell.low[0], cell.high[0], a, 2 * samples)).point));
        cells.push_back(cell);
        boxes.push_back(box);
    }
    return finished(std::move(cells), boxes);
}

double least_distance(const CadParts& parts, std::size_t face, const Vec<3>& p) {
    const Cells& cells = parts.faces[face];
    const auto nearest = cells.tree.nearest(p, [&](std::size_t i) {
        return std::max(cells.boxes[i].distance_squared(p), cells.oriented[i].distance_squared(p));
    });
    return std::sqrt(std::max(nearest.distance_squared, cells.reach.distance_squared(p)));
}

}  // namespace camber
