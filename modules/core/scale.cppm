export module camber.core:scale;

/// The range of lengths that Camber computes with, in model units. Products of four lengths (determinants of triangles'
/// derivatives, squared areas) and of three and their rounding errors, and squares of a metric's entries, are then
/// numbers with all their digits, also for elements far thinner than they are long. From 1e-77 and 1e77 on they are
/// not.
export namespace camber {

/// Elements and facets are at least as large as this in some coordinate; sizes of metrics are no smaller.
inline constexpr double min_length = 1e-60;
/// Coordinates are no larger than this, neither are sizes of metrics.
inline constexpr double max_length = 1e60;

}  // namespace camber
