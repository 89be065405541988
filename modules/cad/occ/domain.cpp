#include "domain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <mutex>
#include <optional>
#include <vector>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Precision.hxx>
#include <TopAbs_State.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Pnt2d.hxx>

#include "kernel.hpp"

namespace camber::occ {

namespace {

constexpr std::size_t most_cells = 1024;  // each way

/// Cells each way: more for a face with many edges, which may be holes.
std::size_t side_for(const TopoDS_Face& face) {
    constexpr double least = 64, most = 256, edges_of_few = 4;
    std::size_t edges = 0;
    for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next()) ++edges;
    return static_cast<std::size_t>(
        std::clamp(least * std::sqrt(static_cast<double>(edges) / edges_of_few), least, most));
}

}  // namespace

DomainGrid::DomainGrid(const TopoDS_Face& face, const FaceFacts& facts, BRepTopAdaptor_FClass2d& domain,
                       std::size_t fineness)
    : low_(facts.low),
      high_(facts.high),
      side_(std::min(most_cells, fineness * side_for(face))),
      is_known_(side_ * side_, false),
      is_inside_(side_ * side_, false) {
    constexpr std::size_t pieces = 128;
    const auto crossed = crossed_by_edges(face, fineness * pieces);
    if (crossed.empty()) return;
    std::vector<bool> is_grouped = crossed;
    for (std::size_t cell = 0; cell < is_known_.size(); ++cell)
        if (!is_grouped[cell]) decide(group_of(cell, is_grouped), domain);
}

std::optional<bool> DomainGrid::has(double u, double v) const {
    const std::array<double, 2> uv{u, v};
    for (std::size_t k = 0; k < 2; ++k)
        if (!(uv[k] >= low_[k] && uv[k] <= high_[k])) return std::nullopt;
    const std::size_t cell = cell_of(u, 0) * side_ + cell_of(v, 1);
    return is_known_[cell] ? std::optional<bool>(is_inside_[cell]) : std::nullopt;
}

std::size_t DomainGrid::cell_of(double x, std::size_t k) const {
    const double at = (x - low_[k]) / (high_[k] - low_[k]) * static_cast<double>(side_);
    return at >= 0 ? std::min(static_cast<std::size_t>(std::min(at, static_cast<double>(side_))), side_ - 1) : 0;
}

double DomainGrid::middle_of(std::size_t cell, std::size_t k) const {
    return low_[k] + (high_[k] - low_[k]) * (static_cast<double>(cell) + 0.5) / static_cast<double>(side_);
}

std::vector<bool> DomainGrid::crossed_by_edges(const TopoDS_Face& face, std::size_t pieces) const {
    std::vector<bool> crossed(side_ * side_, false);
    for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next()) {
        double first = 0, last = 0;
        const auto curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(at.Current()), face, first, last);
        if (curve.IsNull()) return {};
        gp_Pnt2d from = curve->Value(first);
        for (std::size_t i = 1; i <= pieces; ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(pieces);
            const gp_Pnt2d to = curve->Value(first + (last - first) * share);
            mark(from, to, crossed);
            from = to;
        }
    }
    return crossed;
}

void DomainGrid::mark(const gp_Pnt2d& from, const gp_Pnt2d& to, std::vector<bool>& crossed) const {
    constexpr double beside = 1e-6;  // of the face, for edges that run along a border of cells
    std::array<std::size_t, 2> begin{}, end{};
    for (std::size_t k = 0; k < 2; ++k) {
        const auto [a, b] = std::minmax(k == 0 ? from.X() : from.Y(), k == 0 ? to.X() : to.Y());
        const double more = b - a + beside * (high_[k] - low_[k]);
        begin[k] = cell_of(a - more, k);
        end[k] = cell_of(b + more, k);
    }
    for (std::size_t i = begin[0]; i <= end[0]; ++i)
        for (std::size_t j = begin[1]; j <= end[1]; ++j) crossed[i * side_ + j] = true;
}

std::vector<std::size_t> DomainGrid::group_of(std::size_t cell, std::vector<bool>& is_grouped) const {
    std::vector<std::size_t> group{cell};
    is_grouped[cell] = true;
    const auto add = [&](std::size_t neighbour) {
        if (is_grouped[neighbour]) return;
        is_grouped[neighbour] = true;
        group.push_back(neighbour);
    };
    for (std::size_t next = 0; next < group.size(); ++next) {
        const std::size_t i = group[next] / side_, j = group[next] % side_;
        if (i > 0) add(group[next] - side_);
        if (i + 1 < side_) add(group[next] + side_);
        if (j > 0) add(group[next] - 1);
        if (j + 1 < side_) add(group[next] + 1);
    }
    return group;
}

void DomainGrid::decide(const std::vector<std::size_t>& group, BRepTopAdaptor_FClass2d& domain) {
    constexpr std::size_t tries = 5;
    std::optional<TopAbs_State> state;
    for (std::size_t n = 0; n < std::min(tries, group.size()); ++n) {
        const std::size_t cell = group[n * group.size() / std::min(tries, group.size())];
        const TopAbs_State found = domain.Perform(gp_Pnt2d(middle_of(cell / side_, 0), middle_of(cell % side_, 1)));
        if ((found != TopAbs_IN && found != TopAbs_OUT) || found != state.value_or(found)) return;
        state = found;
    }
    for (const std::size_t cell : group) {
        is_known_[cell] = true;
        is_inside_[cell] = state == TopAbs_IN;
    }
}

Domain::Domain(const TopoDS_Face& face, const FaceFacts& facts)
    : face_(face), facts_(facts), classifier_(face, Precision::PConfusion()), coarse_(face, facts, classifier_, 1) {}

std::optional<bool> Domain::has_at_once(double u, double v) const {
    constexpr std::size_t fineness = 4;
    if (const auto known = coarse_.has(u, v)) return known;
    std::call_once(refined_, [&] {
        const std::lock_guard lock(alone_);
        fine_.emplace(face_, facts_, classifier_, fineness);
    });
    return fine_->has(u, v);
}

bool Domain::has(double u, double v) const {
    const std::lock_guard lock(alone_);
    const TopAbs_State found = classifier_.Perform(gp_Pnt2d(u, v));
    return found == TopAbs_IN || found == TopAbs_ON;
}

}  // namespace camber::occ
