module;
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.recovery;
import camber.core;

namespace camber {

template <int D>
void Rings<D>::begin(VertexId v, Reference material) {
    material_ = material;
    count_ = 0;
    seen_nodes_.forget();
    seen_elements_.forget();
    seen_nodes_.insert(v.value);
    nodes_.assign(1, v.value);
    last_.assign(1, v);
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
