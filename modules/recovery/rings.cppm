module;
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.recovery:rings;
import camber.core;

namespace camber {

/// Numbers that were seen since `forget`, at the cost of those seen.
class SeenSet {
  public:
    void forget() {
        count_ = 0;
        if (++stamp_ != 0) return;
        table_.assign(table_.size(), {});  // the stamps have gone round
        stamp_ = 1;
    }
    /// False if it was seen before.
    bool insert(std::uint32_t number) {
        if (2 * (count_ + 1) > table_.size()) grow();
        return put(number);
    }

  private:
    struct Entry {
        std::uint32_t number = 0, stamp = 0;
    };
    bool put(std::uint32_t number) {
        const std::size_t mask = table_.size() - 1;
        for (std::size_t at = (number * std::size_t{0x9e3779b97f4a7c15U}) >> shift_;; at = (at + 1) & mask) {
            Entry& entry = table_[at];
            if (entry.stamp != stamp_) {
                entry = {number, stamp_};
                ++count_;
                return true;
            }
            if (entry.number == number) return false;
        }
    }
    void grow() {
        std::vector<Entry> before(table_.empty() ? 256 : 2 * table_.size());
        before.swap(table_);
        shift_ = 64 - std::countr_zero(table_.size());
        count_ = 0;
        for (const Entry& entry : before)
            if (entry.stamp == stamp_) put(entry.number);
    }

    std::vector<Entry> table_;
    std::uint32_t stamp_ = 1;
    int shift_ = 0;
    std::size_t count_ = 0;
};

/// The nodes of a field of degree 1 or 2, by number: the vertices, then (degree 2) the edges.
template <int D>
struct NodalMesh {
    const QuadraticMesh<D>& mesh;
    const Incidence<ElementId>& balls;
    int degree = 1;

    [[nodiscard]] Vec<D> place(std::uint32_t node) const {
        const std::size_t vertices = mesh.linear.points.size();
        return node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point;
    }
};

/// Ring after ring of nodes around a vertex or an element, through elements of one material.
template <int D>
class Rings {
  public:
    explicit Rings(const NodalMesh<D>& nodal) : nodal_(nodal) {}

    /// The vertex alone.
    void begin(VertexId v, Reference material);
    /// The element's vertices, of its material.
    void begin(ElementId e);
    /// Adds all nodes of the elements at the vertices that are new since the last ring. False if there are none.
    bool grow();

    [[nodiscard]] int count() const { return count_; }  ///< of rings
    /// All so far; first those of the beginning.
    [[nodiscard]] std::span<const std::uint32_t> nodes() const { return nodes_; }
    /// Those of the last ring.
    [[nodiscard]] std::span<const VertexId> last_vertices() const { return last_; }

  private:
    void begin(std::span<const VertexId> vertices, Reference material);

    NodalMesh<D> nodal_;
    Reference material_ = 0;
    int count_ = 0;
    SeenSet seen_nodes_, seen_elements_;
    std::vector<std::uint32_t> nodes_;
    std::vector<VertexId> last_, next_;
};

}  // namespace camber
