/// One operation of the cavity operator (paper §1.3, §3.2), of degree 1 and 2: a request becomes a star, nodes, a
/// judged patch; and rounds of many.
export module camber.operation;
import :curved_nodes;
export import :geometry;
export import :operate;
export import :state;
