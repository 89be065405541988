module;
#include <tuple>
#include <vector>
export module camber.recipes:geometry_sizes;
import camber.core;
import camber.solution_metric;
import camber.surface;

export namespace camber {

/// What the geometry of a mesh's boundary asks of sizes by itself.
struct GeometrySizes {
    std::vector<Reference> references = {};  ///< of the facets that ask; empty: all
    double chord_error = 0, angle = 0;       ///< as of ChordOptions
    double normal_ratio = ChordOptions{}.normal_ratio;
    double gap_elements = 0;  ///< across the domain where it is thin, as of GapOptions

    [[nodiscard]] static constexpr auto options() {
        using S = GeometrySizes;
        return std::tuple(
            option("references", &S::references, "of the boundary facets that ask; empty: all").count(0, 100000),
            option_of(&ChordOptions::chord_error).as(&S::chord_error), option_of(&ChordOptions::angle).as(&S::angle),
            option_of(&ChordOptions::normal_ratio).as(&S::normal_ratio),
            option("gap_elements", &S::gap_elements,
                   "how many elements there shall be across the domain where it is thin; 0: any number")
                .at_least(0));
    }
    [[nodiscard]] bool are_asked() const { return chord_error > 0 || angle > 0 || gap_elements > 0; }
    friend bool operator==(const GeometrySizes&, const GeometrySizes&) = default;
};

/// The metrics of such sizes at the vertices of the boundary, straight or with its curves; `features` say where it
/// breaks. Gaps are measured between straight facets. No size is above `largest`. Errors (usage): nothing asked, a
/// reference that no facet has; those of `chord_metrics` and `gap_metrics`.
template <int D>
[[nodiscard]] Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const LinearMesh<D>& mesh,
                                                                        const Features<D>& features,
                                                                        const GeometrySizes& asked, double largest,
                                                                        const Execution& execution);
template <int D>
[[nodiscard]] Outcome<std::vector<MetricsAtVertices<D>>> geometry_sizes(const QuadraticMesh<D>& mesh,
                                                                        const Features<D>& features,
                                                                        const GeometrySizes& asked, double largest,
                                                                        const Execution& execution);

}  // namespace camber
