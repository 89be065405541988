/// Cavity operations of degree 1 and 2 (paper §1.3, §3.2), and passes of many operations.
export module camber.operation;
import :curved_nodes;
export import :geometry;
export import :operate;
export import :state;
