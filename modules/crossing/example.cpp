// Example of camber.crossing: two plane curves cross although their chords do not.
#include <cstdio>
#include <vector>

import camber.core;
import camber.bezier;
import camber.crossing;

using namespace camber;

int main() {
    const NodalFacet<2> lower{{Vec<2>{{0, 0}}, Vec<2>{{1, 0}}, Vec<2>{{0.5, 0.2}}}};
    const NodalFacet<2> upper{{Vec<2>{{0, 0.3}}, Vec<2>{{1, 0.3}}, Vec<2>{{0.5, 0.1}}}};
    const Crossing chords = crossing_of(straight_facet<2>({lower.nodes[0], lower.nodes[1]}),
                                        straight_facet<2>({upper.nodes[0], upper.nodes[1]}));
    const Crossing curves = crossing_of(lower, upper);
    std::printf("chords: %s, curves: %s\n", word(chords).data(), word(curves).data());

    // A dynamic grid of boxes finds candidate pairs.
    FacetGrid<2> grid;
    grid.insert(FacetId(0), box_of(lower));
    std::vector<FacetId> near;
    grid.meeting(box_of(upper), near);
    return chords == Crossing::disjoint && curves == Crossing::crossing && near.size() == 1 ? 0 : 1;
}
