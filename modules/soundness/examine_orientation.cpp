module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.soundness;
import camber.core;
import camber.validity;
import :examination;

namespace camber {

namespace {

/// Whether two elements with a common face are numbered alike: then the face, seen from either as outwards, runs in
/// opposite senses.
template <int D>
bool numbered_alike(const SimplexVertices<D>& element, int opposite, const SimplexVertices<D>& other) {
    const auto mine = face_of<D>(element, opposite);
    int there = 0;
    while (has(mine, other[there])) ++there;
    const auto theirs = face_of<D>(other, there);
    int inversions = 0;
    std::array<int, D> at{};
    for (int i = 0; i < D; ++i)
        at[i] = static_cast<int>(std::find(theirs.begin(), theirs.end(), mine[i]) - theirs.begin());
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < i; ++j) inversions += at[j] > at[i];
    return inversions % 2 == 1;
}

/// Numbers each piece of the mesh (elements joined by faces) alike, and positive on the whole: 1 for elements that are
/// to be turned for that. A Möbius strip of elements keeps a seam; in its own dimension there is none.
template <int D>
Buffer<std::uint8_t> turns(const LinearMesh<D>& mesh, const Buffer<double>& volumes, const Examination<D>& x) {
    constexpr std::uint8_t unseen = 2;
    Buffer<std::uint8_t> turned(volumes.size());
    std::fill(turned.begin(), turned.end(), unseen);
    std::vector<std::uint32_t> piece;
    for (std::size_t seed = 0; seed < volumes.size(); ++seed) {
        if (turned[seed] != unseen) continue;
        turned[seed] = 0;
        piece.assign(1, static_cast<std::uint32_t>(seed));
        double volume = 0;
        for (std::size_t next = 0; next < piece.size(); ++next) {
            const std::size_t e = piece[next];
            volume += turned[e] == 1 ? -volumes[e] : volumes[e];
            if (!x.element_counts(e)) continue;
            for (int i = 0; i <= D; ++i) {
                const std::uint32_t other = x.neighbours[e][i];
                if (other >= several || turned[other] != unseen) continue;
                const bool alike = numbered_alike<D>(mesh.elements.vertices[e], i, mesh.elements.vertices[other]);
                turned[other] = static_cast<std::uint8_t>(alike ? turned[e] : 1 - turned[e]);
                piece.push_back(other);
            }
        }
        if (volume < 0)
            for (const std::uint32_t e : piece) turned[e] = static_cast<std::uint8_t>(1 - turned[e]);
    }
    return turned;
}

/// Whether an element is negative or numbered unlike a neighbour.
template <int D>
bool is_suspect(const LinearMesh<D>& mesh, const Buffer<double>& volumes, const Examination<D>& x, std::size_t e) {
    if (!x.element_counts(e)) return false;
    if (volumes[e] < 0) return true;
    for (int i = 0; i <= D; ++i) {
        const std::uint32_t other = x.neighbours[e][i];
        if (other < several && !numbered_alike<D>(mesh.elements.vertices[e], i, mesh.elements.vertices[other]))
            return true;
    }
    return false;
}

}  // namespace

template <int D>
Outcome<Done> examine_orientation(const LinearMesh<D>& mesh, const Buffer<double>& volumes, Examination<D>& x,
                                  const Execution& execution) {
    const std::size_t n = volumes.size();
    auto suspects = count(execution, n, [&](std::size_t e) { return is_suspect(mesh, volumes, x, e); });
    if (!suspects) return fail(suspects.error());
    if (suspects->count > 0) {
        x.turned = turns(mesh, volumes, x);
    } else {
        x.turned.resize(n);
        std::fill(x.turned.begin(), x.turned.end(), std::uint8_t{0});
    }
    const auto is_tangled = [&](std::size_t e) { return x.turned[e] == 1 ? volumes[e] > 0 : volumes[e] < 0; };
    const Execution quiet = without_progress(execution);
    auto reversed =
        count(quiet, n, [&](std::size_t e) { return x.element_counts(e) && x.turned[e] == 1 && !is_tangled(e); });
    if (!reversed) return fail(reversed.error());
    auto tangled = count(quiet, n, [&](std::size_t e) { return x.element_counts(e) && is_tangled(e); });
    if (!tangled) return fail(tangled.error());
    auto flat = count(quiet, n, [&](std::size_t e) { return x.element_counts(e) && volumes[e] == 0; });
    if (!flat) return fail(flat.error());
    x[Defect::reversed_element] = *reversed;
    x[Defect::tangled_element] = *tangled;
    x[Defect::flat_element] = *flat;
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<Done> examine_orientation<D>(const LinearMesh<D>&, const Buffer<double>&, Examination<D>&, \
                                                  const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
