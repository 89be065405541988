module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.transfer:sources;
import camber.core;
import camber.bezier;
import camber.metric;
import :key_table;
import :materials;

namespace camber {

/// A place in the old mesh: an element of it and ξ there.
template <int D>
struct OldPlace {
    std::uint32_t element = none;
    Barycentric<D> xi{};
    Placement placement = Placement::inside;
    double distance = 0;  ///< of the point from that place, where it is outside
};

/// The old mesh, and its parts of one material each, with what location in them needs. A point beyond a part is
/// answered by the nearest point of the part's boundary.
template <int D>
class Sources {
  public:
    /// Of the materials that `is_asked`.
    [[nodiscard]] static Outcome<Sources> make(const QuadraticMesh<D>& mesh, const Materials<D>& materials,
                                               const std::vector<std::uint8_t>& is_asked, const Execution& execution);

    /// The place of a point, as one of that material sees it. `hint`: an old element near it, or `none`.
    [[nodiscard]] OldPlace<D> find(const Vec<D>& p, std::size_t material, std::uint32_t hint) const;

    /// The old element across a face of one, as that material sees it; `none` at its boundary.
    [[nodiscard]] std::uint32_t across(std::size_t material, std::uint32_t element, std::size_t opposite) const;

  private:
    struct Part {
        CurvedLocator<D> locator;
        Column<std::uint32_t> elements;  ///< their numbers in the old mesh; empty: all, with their own
    };
    Outcome<Done> add_part(const QuadraticMesh<D>& mesh, std::size_t material,
                           const std::vector<std::uint32_t>& elements, Buffer<VertexId>& number,
                           const Execution& execution);
    [[nodiscard]] ElementId hint_in(const Part& part, std::size_t material, const Vec<D>& p, std::uint32_t hint) const;

    std::vector<Part> parts_;               ///< of each material; of the rest all elements
    Buffer<std::uint32_t> material_;        ///< of each old element; empty: there is but the rest
    Buffer<std::uint32_t> number_in_part_;  ///< of each old element
};

}  // namespace camber
