module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.recovery;
import camber.core;

namespace camber {

template <int D>
void Rings<D>::begin(std::span<const VertexId> vertices, Reference material) {
    material_ = material;
    count_ = 0;
    seen_nodes_.forget();
    seen_elements_.forget();
    nodes_.clear();
    last_.assign(vertices.begin(), vertices.end());
    for (const VertexId v : vertices) {
        seen_nodes_.insert(v.value);
        nodes_.push_back(v.value);
    }
}

template <int D>
void Rings<D>::begin(VertexId v, Reference material) {
    begin({&v, 1}, material);
}

template <int D>
void Rings<D>::begin(ElementId e) {
    const auto& elements = nodal_.mesh.linear.elements;
    begin(elements.vertices[e], elements.references[e]);
}

template <int D>
bool Rings<D>::grow() {
    const LinearMesh<D>& mesh = nodal_.mesh.linear;
    const std::size_t before = nodes_.size();
    next_.clear();
    for (const VertexId v : last_)
        for (const ElementId e : nodal_.balls[v]) {
            if (mesh.elements.references[e] != material_ || !seen_elements_.insert(e.value)) continue;
            for (const VertexId w : mesh.elements.vertices[e])
                if (seen_nodes_.insert(w.value)) {
                    nodes_.push_back(w.value);
                    next_.push_back(w);
                }
            if (nodal_.degree < 2) continue;
            const auto first = static_cast<std::uint32_t>(mesh.points.size());
            for (const EdgeId edge : nodal_.mesh.edges.of_elements[e])
                if (seen_nodes_.insert(first + edge.value)) nodes_.push_back(first + edge.value);
        }
    last_.swap(next_);
    ++count_;
    return nodes_.size() > before;
}

template class Rings<2>;
template class Rings<3>;

}  // namespace camber
