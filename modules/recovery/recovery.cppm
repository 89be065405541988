/// Gradient, Hessian and third derivatives of fields that are known by their values at a mesh's nodes: what metrics for
/// adaptation are made from.
export module camber.recovery;
export import :material_rows;
export import :derivatives;
export import :element_values;
export import :own_unit;
export import :node_order;
export import :normal_gradients;
import :monomials;
import :whitening;
import :rings;
import :fit;
import :polynomial;
import :checks;
import :at_lattice;
