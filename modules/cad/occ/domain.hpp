#pragma once

#include <array>
#include <cstddef>
#include <mutex>
#include <optional>
#include <vector>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Pnt2d.hxx>

#include "kernel.hpp"

namespace camber::occ {

/// A grid over the parameters of a trimmed face. Cells that no edge of the face crosses are inside of it or outside as
/// a whole, which OpenCASCADE decides once for each group of neighbours; points in other cells are left to it.
class DomainGrid {
  public:
    /// `fineness`: factor on the number of cells each way.
    DomainGrid(const TopoDS_Face& face, const FaceFacts& facts, BRepTopAdaptor_FClass2d& domain, std::size_t fineness);

    /// Whether the face has a point; nothing where the point is in a cell that an edge may cross.
    [[nodiscard]] std::optional<bool> has(double u, double v) const;

  private:
    [[nodiscard]] std::size_t cell_of(double x, std::size_t k) const;
    [[nodiscard]] double middle_of(std::size_t cell, std::size_t k) const;
    /// Cells that meet the box of two neighbouring points of an edge, widened by its size; nothing where an edge has no
    /// curve in the parameters.
    [[nodiscard]] std::vector<bool> crossed_by_edges(const TopoDS_Face& face, std::size_t pieces) const;
    void mark(const gp_Pnt2d& from, const gp_Pnt2d& to, std::vector<bool>& crossed) const;
    /// The cells that are connected with one, which are grouped from then on.
    [[nodiscard]] std::vector<std::size_t> group_of(std::size_t cell, std::vector<bool>& is_grouped) const;
    /// By some cells of a group; where they disagree, as those of a loop that does not close may, it stays unknown.
    void decide(const std::vector<std::size_t>& group, BRepTopAdaptor_FClass2d& domain);

    std::array<double, 2> low_, high_;
    std::size_t side_;
    std::vector<bool> is_known_, is_inside_;
};

/// The parameters of a trimmed face. Several threads may ask at once; no answer depends on their order.
class Domain {
  public:
    Domain(const TopoDS_Face& face, const FaceFacts& facts);

    /// Whether the face has a point; nothing where only OpenCASCADE can decide it, which takes a hundred times as long.
    [[nodiscard]] std::optional<bool> has_at_once(double u, double v) const;
    /// As OpenCASCADE decides. Throws Standard_Failure.
    [[nodiscard]] bool has(double u, double v) const;

  private:
    TopoDS_Face face_;
    FaceFacts facts_;
    mutable std::mutex alone_;  ///< OpenCASCADE gave wrong answers to several threads at once
    mutable BRepTopAdaptor_FClass2d classifier_;
    DomainGrid coarse_;
    mutable std::once_flag refined_;
    mutable std::optional<DomainGrid> fine_;  ///< made when the first point is in an undecided cell of the coarse one
};

}  // namespace camber::occ
