module;
#include <string_view>
#include <vector>
module camber.io:losses;
import camber.core;
import :notice;

namespace camber {

/// What a format has a place for, of what meshes have beside nodes, simplices and references.
struct Holds {
    bool groups = false;        ///< names of references
    bool entities = false;      ///< the entities that simplices lie on
    bool associations = false;  ///< the entities that vertices lie on, and where
    bool corners = false, ridges = false, required = false;
    bool directions = false;    ///< normals and tangents
    bool feature_edges = true;  ///< simplices of dimension 1 in a 3D mesh
    bool point_references = true;
};

/// A sentence for each kind of things that the mesh has and the format of that name does not hold, with their number.
template <int D>
[[nodiscard]] std::vector<Notice> not_held(const LinearMesh<D>& mesh, Holds holds, std::string_view format);

/// For formats with one name a reference: the simplices that are in further groups, by these.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_further_groups(const LinearMesh<D>& mesh, std::string_view format);

}  // namespace camber
