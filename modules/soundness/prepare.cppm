module;
#include <string>
#include <vector>
export module camber.soundness:prepare;
import camber.core;
import camber.validity;
import :defects;

export namespace camber {

/// A mesh to work on, and what was done or is worth knowing: sentences without a full stop.
template <class Mesh>
struct Prepared {
    Mesh mesh;
    std::vector<std::string> notices;
};

/// Mends what can be mended without a doubt, and refuses what is no mesh:
/// - elements and facets that repeat earlier ones are dropped;
/// - facets that are a face of no element are dropped, in a mesh that has elements;
/// - reversed elements are turned by swapping their first two vertices. Tangled ones are numbered as their neighbours
///   are, so that their volume is negative and every check sees it; no order of their vertices would make them right;
/// - faces of the boundary, and between elements of different references, that are not listed become facets with fresh
///   references, one for each kind, after those in use by facets and by names of groups of facets.
/// Vertices, and their order, stay. A sound mesh is given back as it is. Errors: input (the fatal defects of
/// `Soundness`, an empty mesh), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Prepared<LinearMesh<D>>> prepare(LinearMesh<D> mesh, const Execution& execution);

/// The same; curved edges keep their nodes.
template <int D>
[[nodiscard]] Outcome<Prepared<QuadraticMesh<D>>> prepare(QuadraticMesh<D> mesh, const Execution& execution);

}  // namespace camber
