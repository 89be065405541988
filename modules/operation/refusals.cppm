module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
export module camber.operation:refusals;
import camber.core;
import camber.cavity;

export namespace camber {

/// The passes that ask again and again for the same.
enum class AskingPass : std::uint8_t { collapse, swap, smooth, remove };
inline constexpr std::size_t asking_passes = 4;

/// What each of them asked for in vain, by the entity that it asked at. Such a request depends on the elements at the
/// entity's vertices alone (but for facets of other walls): as long as none of these has changed it stands refused, and
/// need not be made again. Time is counted in commits.
class Refusals {
  public:
    /// A pass begins. What was refused for other limits is forgotten.
    void begin(AskingPass pass, std::vector<double> limits) {
        OfPass& of = of_[static_cast<std::size_t>(pass)];
        if (of.limits != limits) of = {std::move(limits), {}};
    }
    /// Of a mesh that has not changed since the requests were planned.
    template <class Tag>
    void refuse(AskingPass pass, std::span<const Id<Tag>> ids, std::size_t entities) {
        if (ids.empty()) return;
        OfPass& of = of_[static_cast<std::size_t>(pass)];
        auto asked = take(std::move(of.asked));
        asked.resize(entities, never);
        for (const Id<Tag> id : ids) asked[id.index()] = now_ + 1;
        of.asked = std::move(asked);
    }
    /// Whether the request at an entity with these vertices was refused and nothing has changed there since.
    template <class Tag>
    [[nodiscard]] bool stands(AskingPass pass, Id<Tag> id, std::span<const VertexId> vertices) const {
        const auto& asked = of_[static_cast<std::size_t>(pass)].asked;
        if (id.index() >= asked.size() || asked[id] == never) return false;
        for (const VertexId v : vertices)
            if (v.index() < changed_.size() && changed_[v] >= asked[id]) return false;
        return true;
    }
    /// A commit made these elements.
    template <int D>
    void follow(const DynamicMesh<D>& mesh, std::span<const ElementId> created) {
        ++now_;
        auto changed = take(std::move(changed_));
        changed.resize(mesh.points.size(), never);
        for (const ElementId e : created)
            if (!mesh.is_free(e))
                for (const VertexId v : mesh.elements.vertices[e])
                    if (!mesh.is_at_infinity(v)) changed[v.index()] = now_;
        changed_ = std::move(changed);
    }
    void forget() { of_ = {}; }

  private:
    static constexpr std::uint32_t never = 0;
    struct OfPass {
        std::vector<double> limits;
        Column<std::uint32_t> asked;  ///< of each entity: after how many commits it was last refused, and one
    };
    std::array<OfPass, asking_passes> of_;
    Column<std::uint32_t> changed_;  ///< of each vertex: the last commit that made an element of it
    std::uint32_t now_ = 0;          ///< commits
};

}  // namespace camber
