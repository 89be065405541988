/// Riemannian metrics: SPD algebra, log-Euclidean fields on back meshes, lengths and energies of P2 edges with their
/// derivatives, and the node that minimises them.
export module camber.metric;
import :packs;
export import :eigen;
export import :spd;
export import :batches;
export import :matrix_derivatives;
export import :natural;
export import :tensors;
export import :quadrature;
import :element_frame;
export import :back_mesh;
import :straight_back;
import :curved_back;
import :along_edge;
export import :high_order;
export import :edge_length;
export import :edge_objective;
import :unit_frame;
import :edge_sectors;
export import :edge_minimiser;
import :edge_search;
export import :edge_barycentric;
export import :edge_accuracy;
export import :intersection;
export import :operations;
export import :gradation;
export import :surface_metric;
