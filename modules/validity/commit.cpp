module;
#include <cstddef>
#include <string>
module camber.validity;
import camber.core;
import :surface_triangle;

namespace camber {

namespace {

template <int D>
MeshMaps identities(const QuadraticMesh<D>& mesh) {
    return {IdMap<VertexId>::identity(mesh.linear.points.size()), IdMap<EdgeId>::identity(mesh.edges.size()),
            IdMap<ElementId>::identity(mesh.linear.elements.size()),
            IdMap<FacetId>::identity(mesh.linear.facets.size())};
}

/// The first element of which det J > 0 is not certified. There is one.

}  // namespace

template <int D>
Outcome<Committed<D>> commit(const JudgedProposal<D>& judged) {
    const Validation<D>& validation = judged.validation();
    if (!validation.certified())
        return fail(ErrorKind::input,
                    "is not certified valid, one of " + std::to_string(validation.not_positive.size()) +
                        " of which det J > 0 is not certain",
                    {},
                    Entity{is_surface_alone(judged.mesh().linear) ? simplex_name<2> : simplex_name<D>,
                           validation.not_positive.front().first.index() + 1},
                    "put a relax stage before commit");
    return commit_uncertified(judged);
}

template <int D>
Committed<D> commit_uncertified(const JudgedProposal<D>& judged) {
    return {apply_proposal(judged.mesh(), judged.proposal()), identities(judged.mesh())};
}

#define CAMBER_INSTANTIATE(D)                                           \
    template Outcome<Committed<D>> commit<D>(const JudgedProposal<D>&); \
    template Committed<D> commit_uncertified<D>(const JudgedProposal<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
