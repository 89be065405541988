/// The boundary's shape: features, the P3 surrogate made from the mesh alone, analytic surfaces, projection, and the
/// nodes of boundary edges. The partitions fans, given_directions, junctions, tangents, heights and normals export
/// nothing: they serve the surrogate.
export module camber.surface;
export import :features;
export import :fit;
export import :cubic;
export import :cubic_packs;
export import :plane;
export import :analytic;
export import :surrogate;
export import :curved_surrogate;
export import :geometry_places;
export import :geometry;
export import :edge_sheet;
export import :seams;
export import :makers;
export import :boundary;
export import :embedded_curves;
export import :distances;
export import :inspection;
import :analytic_parameters;
import :geometry_sheets;
import :meeting;
import :cut_boundary;
import :kinks;
import :fans;
export import :flat;
import :given_directions;
import :tangents;
import :heights;
import :junctions;
import :normals;
