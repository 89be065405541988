module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.transfer;
import :fields;
import :interpolate;
import :key_table;
import :materials;
import :node_materials;
import :same;
import :simplex;
import :sources;
import :transferred;
import camber.core;
import camber.bezier;
import camber.metric;

namespace camber {

namespace {

/// What became of some nodes.
struct Counts {
    std::size_t kept = 0, inside = 0, outside = 0, lost = 0;
    double largest_distance = 0;
};
Counts together(Counts a, const Counts& b) {
    a.kept += b.kept;
    a.inside += b.inside;
    a.outside += b.outside;
    a.lost += b.lost;
    a.largest_distance = std::max(a.largest_distance, b.largest_distance);
    return a;
}

/// Of each old node one of its elements, or `none`.
template <int D>
Buffer<std::uint32_t> elements_at_nodes(const QuadraticMesh<D>& mesh) {
    Buffer<std::uint32_t> at(node_count_of(mesh, 2), none);
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        for (const std::size_t n : nodes_of<D, 2>(mesh, e)) at[n] = static_cast<std::uint32_t>(e);
    return at;
}

template <int D>
class Interpolation {
  public:
    Interpolation(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                  const QuadraticMesh<D>& new_mesh, const Materials<D>& materials, const Same& same,
                  const Sources<D>& sources)
        : old_(old_mesh),
          fields_(fields),
          new_(new_mesh),
          same_(same),
          sources_(sources),
          materials_(new_mesh, materials),
          old_element_at_(elements_at_nodes(old_mesh)) {
        for (const TransferField& field : fields) {
            nodes_ = std::max(nodes_, node_count_of(new_mesh, field.degree));
            out_.values.emplace_back(node_count_of(new_mesh, field.degree) *
                                     static_cast<std::size_t>(field.components));
        }
        out_.near.assign(new_mesh.linear.points.size(), none);
    }

    [[nodiscard]] Outcome<Interpolated> run(const Execution& execution) {
        const std::size_t vertices = new_.linear.points.size();
        auto of_vertices = values_of(0, vertices, part_of(execution, 0, 0.15));
        if (!of_vertices) return fail(of_vertices.error());
        auto of_edges = values_of(vertices, std::max(nodes_, vertices), part_of(execution, 0.15, 1));
        if (!of_edges) return fail(of_edges.error());
        const Counts all = together(*of_vertices, *of_edges);
        TransferStatistics& statistics = out_.statistics;
        statistics.kept = all.kept;
        statistics.interpolated = all.inside;
        statistics.outside = all.outside;
        statistics.lost = all.lost;
        statistics.largest_distance = all.largest_distance;
        return std::move(out_);
    }

  private:
    [[nodiscard]] Outcome<Counts> values_of(std::size_t begin, std::size_t end, const Execution& execution) {
        return reduce_each(
            execution, end - begin, Counts{}, [&](Counts& counts, std::size_t i) { put(begin + i, counts); }, together,
            default_grain);
    }

    /// All fields at new node n.
    void put(std::size_t n, Counts& counts) {
        const std::uint32_t same = same_.old_node[n];
        const std::size_t vertices = new_.linear.points.size();
        if (same != none) {
            if (n < vertices) out_.near[n] = old_element_at_[same];
            if (put_kept(n, same)) {
                ++counts.kept;
                return;
            }
        }
        const OldPlace<D> place = find(n);
        if (n < vertices) out_.near[n] = place.element;
        if (place.placement == Placement::inside) {
            ++counts.inside;
        } else {
            ++counts.outside;
            counts.lost += place.placement == Placement::lost ? 1 : 0;
            counts.largest_distance = std::max(counts.largest_distance, place.distance);
        }
        const auto linear = lagrange<D, 1>(place.xi);
        const auto quadratic = lagrange<D, 2>(place.xi);
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            if (!has_node(f, n) || (same != none && old_has_node(f, same))) continue;
            const auto out = row(f, n);
            std::ranges::fill(out, 0.0);
            if (fields_[f].degree == 1)
                add_field<D, 1>(old_, place.element, linear, fields_[f].values.data(), out);
            else
                add_field<D, 2>(old_, place.element, quadratic, fields_[f].values.data(), out);
        }
    }
    /// Copies what the old node has; whether that was all fields. (A field of degree 1 has no value at an edge's node.)
    [[nodiscard]] bool put_kept(std::size_t n, std::uint32_t same) {
        bool all = true;
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            if (!has_node(f, n)) continue;
            all = all && old_has_node(f, same);
            if (!old_has_node(f, same)) continue;
            const auto out = row(f, n);
            std::copy_n(fields_[f].values.data() + same * out.size(), out.size(), out.data());
        }
        return all;
    }

    /// Where the old mesh has new node n: in an element of one of its materials, else nearest to one.
    [[nodiscard]] OldPlace<D> find(std::size_t n) const {
        const Vec<D>& p = place_of(new_, n);
        OldPlace<D> best;
        materials_.visit(n, [&](std::size_t material) {
            const OldPlace<D> here = sources_.find(p, material, hint_of(n));
            if (best.element == none || here.placement == Placement::inside || here.distance < best.distance)
                best = here;
            return here.placement == Placement::inside;
        });
        return best;
    }
    [[nodiscard]] std::uint32_t hint_of(std::size_t n) const {
        const std::size_t vertices = new_.linear.points.size();
        return n < vertices ? out_.near[n] : out_.near[new_.edges.vertices[n - vertices][0].index()];
    }

    [[nodiscard]] bool has_node(std::size_t f, std::size_t n) const {
        return fields_[f].degree == 2 || n < new_.linear.points.size();
    }
    [[nodiscard]] bool old_has_node(std::size_t f, std::uint32_t n) const {
        return fields_[f].degree == 2 || n < old_.linear.points.size();
    }
    [[nodiscard]] std::span<double> row(std::size_t f, std::size_t n) {
        const auto components = static_cast<std::size_t>(fields_[f].components);
        return std::span(out_.values[f]).subspan(n * components, components);
    }

    const QuadraticMesh<D>& old_;
    std::span<const TransferField> fields_;
    const QuadraticMesh<D>& new_;
    const Same& same_;
    const Sources<D>& sources_;
    NodeMaterials materials_;
    Buffer<std::uint32_t> old_element_at_;
    std::size_t nodes_ = 0;  ///< of the field that has most
    Interpolated out_;
};

}  // namespace

template <int D>
Outcome<Interpolated> interpolate(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                                  const QuadraticMesh<D>& new_mesh, const Materials<D>& materials, const Same& same,
                                  const Sources<D>& sources, const Execution& execution) {
    return guarded(
        [&] { return Interpolation<D>(old_mesh, fields, new_mesh, materials, same, sources).run(execution); });
}

template <int D>
std::vector<std::uint8_t> asked_materials(const QuadraticMesh<D>& new_mesh, const Materials<D>& materials) {
    std::vector<std::uint8_t> is_asked(materials.size(), 0);
    std::vector<std::uint8_t> has_element(node_count_of(new_mesh, 2), 0);
    for (std::size_t e = 0; e < new_mesh.linear.elements.size(); ++e) {
        is_asked[materials.of(new_mesh.linear, e)] = 1;
        for (const std::size_t n : nodes_of<D, 2>(new_mesh, e)) has_element[n] = 1;
    }
    if (std::ranges::find(has_element, 0) != has_element.end()) is_asked[materials.rest()] = 1;
    return is_asked;
}

#define CAMBER_INSTANTIATE(D)                                                                                \
    template Outcome<Interpolated> interpolate<D>(const QuadraticMesh<D>&, std::span<const TransferField>,   \
                                                  const QuadraticMesh<D>&, const Materials<D>&, const Same&, \
                                                  const Sources<D>&, const Execution&);                      \
    template std::vector<std::uint8_t> asked_materials<D>(const QuadraticMesh<D>&, const Materials<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
