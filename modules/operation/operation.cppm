/// One operation of the cavity operator (paper §1.3, §3.2), of degree 1 and 2: a request becomes a star, nodes, a
/// judged patch; and rounds of many.
export module camber.operation;
export import :vertex_data;
export import :refusals;
export import :state;
export import :measures;
export import :request;
export import :on_geometry;
export import :near_geometry;
export import :curved_workspace;
export import :judged_patch;
export import :operate;
export import :commit;
export import :quality_bar;
export import :node_shell;
export import :wall_elements;
export import :rounds;
export import :finish;
import :curved_nodes;
import :heights;
import :nodal_facets;
import :node_gain;
import :old_map;
import :star_judge;
import :straight_nodes;
import :task_queue;
import :walls;
