module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>
module camber.transfer:materials;
import camber.core;

namespace camber {

/// Which elements of two meshes are of one material: those of a reference that both have, where each of them has more
/// than one; all others are of the last material, the rest.
template <int D>
class Materials {
  public:
    Materials(const LinearMesh<D>& old_mesh, const LinearMesh<D>& new_mesh) {
        const auto old_references = references_of(old_mesh), new_references = references_of(new_mesh);
        if (old_references.size() <= 1 || new_references.size() <= 1) return;
        for (const Reference r : old_references)
            if (std::ranges::find(new_references, r) != new_references.end()) shared_.push_back(r);
    }

    /// 0 … rest().
    [[nodiscard]] std::size_t of(Reference reference) const {
        const auto at = std::ranges::lower_bound(shared_, reference);
        return at != shared_.end() && *at == reference ? static_cast<std::size_t>(at - shared_.begin()) : rest();
    }
    [[nodiscard]] std::size_t of(const LinearMesh<D>& mesh, std::size_t e) const {
        return shared_.empty() ? 0 : of(mesh.elements.references[e]);
    }
    [[nodiscard]] std::size_t rest() const { return shared_.size(); }
    [[nodiscard]] std::size_t size() const { return shared_.size() + 1; }
    [[nodiscard]] std::optional<Reference> reference(std::size_t material) const {
        if (material == rest()) return std::nullopt;
        return shared_[material];
    }

  private:
    static std::vector<Reference> references_of(const LinearMesh<D>& mesh) {
        std::vector<Reference> all;
        for (const Reference r : mesh.elements.references)
            if (all.empty() || all.back() != r) all.push_back(r);
        std::ranges::sort(all);
        const auto twice = std::ranges::unique(all);
        all.erase(twice.begin(), twice.end());
        return all;
    }

    std::vector<Reference> shared_;  ///< rising
};

}  // namespace camber
