module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.transfer:nearby;
import camber.core;
import camber.bezier;
import camber.metric;
import :key_table;
import :simplex;
import :sources;

namespace camber {

/// The points of one new element in the old mesh: most of them lie in the few old elements that points before them were
/// found in, or beside the last one. Where F(ξ) = p has a solution in one of these p is there; other points are
/// located.
template <int D>
class Nearby {
  public:
    Nearby(const QuadraticMesh<D>& old_mesh, const Sources<D>& sources) : mesh_(old_mesh), sources_(sources) {}

    /// Forgets the element before. `hint`: an old element near the next, or `none`.
    void begin(std::size_t material, std::uint32_t hint) {
        material_ = material;
        hint_ = hint;
        seen_.clear();
        tried_.clear();
    }
    [[nodiscard]] OldPlace<D> find(const Vec<D>& p);
    /// The old elements found since `begin`, each once.
    [[nodiscard]] std::span<const std::uint32_t> seen() const { return seen_; }

  private:
    struct Tried {
        std::uint32_t element = 0;
        ElementMap<D> map;
        Vec<D> centre;             ///< of the element, relative to its origin
        Mat<D> jacobian, inverse;  ///< there
        bool is_seen = false;      ///< a point was found in it
    };
    [[nodiscard]] static bool is_inside(const Tried& here, const Vec<D>& p, Barycentric<D>& xi);
    [[nodiscard]] OldPlace<D> found(std::size_t i, OldPlace<D> place);
    [[nodiscard]] std::size_t remember(std::uint32_t element);
    [[nodiscard]] std::uint32_t next_towards(const Tried& here, const Vec<D>& p) const;

    const QuadraticMesh<D>& mesh_;
    const Sources<D>& sources_;
    std::size_t material_ = 0;
    std::uint32_t hint_ = none;
    std::vector<std::uint32_t> seen_;
    std::vector<Tried> tried_;  ///< these; the one that was found last first
};

}  // namespace camber
