module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>
module camber.cavity;
import camber.core;
import :starring;

namespace camber {

template <int D>
bool Starring<D>::survives(EdgeId edge) const {
    if constexpr (D == 3) {
        const auto& [a, b] = mesh_.edges[edge];
        if (a == point_) return w_.vertices.contains(b);
        if (b == point_) return w_.vertices.contains(a);
        return w_.names.contains(edge);
    } else {
        static_cast<void>(edge);
        return true;
    }
}

template <int D>
void Starring<D>::has_line(EdgeId edge) {
    const auto& [a, b] = mesh_.edges[edge];
    if (const std::uint32_t at = w_.vertices.find(a == point_ ? b : a); at != nothing) w_.to_point[at].is_line = true;
}

template <int D>
bool Starring<D>::pieces_have_ends(std::span<const LineAt> ends) {
    Groups groups(w_.groups, cavity_.lines.size());
    std::vector<std::uint8_t> has_end(cavity_.lines.size(), 0);
    const auto index = [&](const LineAt& end) { return w_.lines.find(end.line.line); };
    for (std::size_t i = 1; i < ends.size(); ++i)
        if (ends[i].vertex == ends[i - 1].vertex) groups.join(index(ends[i]), index(ends[i - 1]));
    for (const LineAt& end : ends)
        if (end.vertex == point_ || w_.vertices.contains(end.vertex)) has_end[groups.root(index(end))] = 1;
    for (std::uint32_t l = 0; l < cavity_.lines.size(); ++l)
        if (has_end[groups.root(l)] == 0) return false;
    return true;
}

template <int D>
StarFailure Starring<D>::lines() {
    if constexpr (D == 3) {
        std::size_t met = 0;  // of the removed lines, by the elements around them
        std::vector<std::uint8_t> is_met(cavity_.lines.size(), 0);
        for (const ElementId e : cavity_.elements)
            for (const EdgeId edge : mesh_.edges_of[e])
                if (const LineId line = mesh_.line_of[edge]; line.valid()) {
                    const std::uint32_t at = w_.lines.find(line);
                    const bool removed = at != nothing;
                    if (removed && is_met[at] == 0) is_met[at] = 1, ++met;
                    const bool of_point = mesh_.edges[edge][0] == point_ || mesh_.edges[edge][1] == point_;
                    if (survives(edge) ? removed && !of_point : !removed) return StarFailure::line;
                    if (of_point && !removed) has_line(edge);
                }
        if (met != cavity_.lines.size()) return StarFailure::line;
        if (cavity_.lines.empty()) return StarFailure::none;
        std::vector<LineAt> ends;
        ends.reserve(2 * cavity_.lines.size());
        for (const LineId l : cavity_.lines)
            for (std::uint32_t k = 0; k < 2; ++k)
                ends.push_back({mesh_.edges[mesh_.lines[l]][1 - k], mesh_.line_references[l], {l, k}});
        std::sort(ends.begin(), ends.end(), [](const LineAt& a, const LineAt& b) {
            return std::tie(a.vertex, a.reference, a.line.line) < std::tie(b.vertex, b.reference, b.line.line);
        });
        if (!pieces_have_ends(ends)) return StarFailure::line;
        for (std::size_t i = 0, next = 0; i < ends.size(); i = next) {
            next = i + 1;
            while (next < ends.size() && ends[next].vertex == ends[i].vertex) ++next;
            const VertexId v = ends[i].vertex;
            if (v == point_) continue;
            const bool stays = w_.vertices.contains(v);
            const bool through = next - i == 2 && ends[i].reference == ends[i + 1].reference;
            // A line that goes on through a vertex goes with it; one that ends there is joined to the point.
            if (stays ? next - i != 1 : !through) return StarFailure::line;
            if (!stays) continue;
            auto& edge = w_.to_point[w_.vertices.find(v)];
            if (edge.is_line) return StarFailure::line;
            edge.is_line = true;
            out_.lines.push_back(ends[i].line);
        }
    }
    return StarFailure::none;
}

template <int D>
StarFailure Starring<D>::line_at_point() {
    if constexpr (D == 3) {
        for (const JoinedLine& joined : out_.lines) meet(mesh_.line_references[joined.line]);
        if (point_.valid()) {
            lines_with(mesh_, w_.outside, point_, w_.lines_at_point);
            passed_before_ = w_.lines_at_point.size();
            for (const LineId l : w_.lines_at_point)
                if (!w_.lines.contains(l)) meet(mesh_.line_references[l]);
        }
    }
    constexpr VertexPlace through = D == 3 ? VertexPlace::line : VertexPlace::surface;
    if (point_.valid()) {
        const VertexPlace now = mesh_.states[point_].place;
        const bool passes = passing_ == 2 && !mixed_;
        if (now == VertexPlace::corner) return passing_ == passed_before_ ? StarFailure::none : StarFailure::line;
        return (now == through ? passes : passing_ == 0) ? StarFailure::none : StarFailure::line;
    }
    if (passing_ == 0) return StarFailure::none;
    out_.place = through;
    return passing_ == 2 && !mixed_ ? StarFailure::none : StarFailure::line;
}

#define CAMBER_INSTANTIATE(D) template class Starring<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
