/// Where nodes ought to be, before validity is asked for: volume edges curved by a metric, or for the shape of their
/// elements; the boundary's displacement extended into the volume; and what it costs an edge to have its node
/// elsewhere.
export module camber.curving;
export import :edge_target;
export import :by_element;
export import :back_mesh_nodes;
export import :curve;
export import :extension;
export import :extension_part;
export import :parts;
export import :placed_nodes;
export import :shape;
export import :smooth_loss;
export import :solution_nodes;
export import :edge_models;
import :edge_energy;
import :error_system;
import :lattice_polynomial;
import :pack_frame;
import :polish;
import :sheet_search;
import :simplex_rule;
import :solution_error;
