export module camber.repair:on_geometry;
import camber.core;
import camber.bezier;
import camber.surface;
import camber.validity;
import :guide;

export namespace camber {

/// The feet of boundary edges' nodes on a geometry, for edges all of whose facets have a prescribed surface
/// (`GeometryModel::prescribes`); others are not to slide. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<FootOnGeometry<D>> feet_on(const Geometry<D>& geometry, const Column<EdgeKind>& boundary_kinds,
                                                 const QuadraticMesh<D>& mesh, const Execution& execution);

/// The same for all boundary edges, whoever made the geometry of their facets.
template <int D>
[[nodiscard]] Outcome<FootOnGeometry<D>> feet_on_any(const Geometry<D>& geometry,
                                                     const Column<EdgeKind>& boundary_kinds,
                                                     const QuadraticMesh<D>& mesh, const Execution& execution);

/// The feet of the boundary's vertices: on the surface that all their edges lie on, or, on a ridge, on the curve that
/// both of its edges lie on. Those at corners, where surfaces or curves differ, and where any is not prescribed are not
/// to slide. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<VertexOnGeometry<D>> vertex_feet_on(const Geometry<D>& geometry, const Features<D>& features,
                                                          const QuadraticMesh<D>& mesh, const Execution& execution);

/// The mesh's own nodes, those of such edges brought onto the geometry, but for required ones. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Column<LagrangeNode<D>>> own_nodes_on(const Geometry<D>& geometry,
                                                            const Column<EdgeKind>& boundary_kinds,
                                                            const QuadraticMesh<D>& mesh, RequiredBoundary required,
                                                            const Execution& execution);

}  // namespace camber
