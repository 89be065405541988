/// Meshes in blocks, beyond one memory. A block is a run of a mesh's vertices and what hangs on them; which blocks
/// there are depends on the mesh alone, and who holds which does not matter to what comes out. A rank works on parts,
/// runs of its blocks with two rings of elements around. Ranks move what parts know between them, and know nothing of
/// elements.
export module camber.distributed;
export import :ranks;
export import :error_bytes;
export import :agreement;
export import :ringed_parts;
export import :rows;
export import :routing;
export import :split;
export import :halo;
export import :whole_surface;
export import :curve_blocks;
export import :quadratic_parts;
export import :gmf_rows;
export import :quadratic_rows;
export import :graph_run;
export import :partition_rows;
export import :adaptation_rows;
export import :block_weights;
export import :cut_parts;
export import :finished_rows;
export import :remesh_blocks;
export import :shared_rows;
import :block_run;
import :dual_graph_rows;
import :curve_runs;
import :first_of_ranks;
import :packing;
import :sending;
import :sent_parts;
import :grown_places;
import :kept_part;
import :moved_nodes;
import :part_layout;
import :parts_of_runs;
import :row_runs;
import :runs_of_rank;
import :simplex_row;
import :part_state;
import :region;
import :repair_blocks;
import :check_part;
