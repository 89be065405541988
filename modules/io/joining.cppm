module;
#include <cstddef>
#include <span>
module camber.io:joining;
import camber.core;
import :listing;

namespace camber::listing {

/// Makes points of several parts one that are at the very same place: the parts' points stand behind one another, and
/// `ends` says where each ends. The first of them stays, with its reference and its values. Points of one part, as on
/// both sides of a slit, stay apart. Returns how many are gone.
template <int D>
std::size_t join_coincident(Mesh<D>& mesh, std::span<const std::size_t> ends);

/// Makes points with the same number one, and sorts them by their numbers, one of each point. Of several the first
/// stays. Returns how many are gone.
template <int D>
std::size_t join_numbered(Mesh<D>& mesh, std::span<const double> numbers);

}  // namespace camber::listing
