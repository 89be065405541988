/// Meshes and solutions to and from bytes; the table of formats, one row each; flat meshes to 2D and back. Nothing here
/// touches files: the shell reads and writes them.
export module camber.io;
export import :notice;
export import :any_mesh;
export import :solution;
export import :gmf;
export import :mesh_fields;
export import :flat;
export import :vtu;
export import :cgns;
export import :formats;
// The partitions below export no names: they are the parts that readers and writers are made of.
import :first_fault;
import :text;
import :text_writer;
import :listing;
import :grid;
import :losses;
import :gmf_keywords;
import :gmf_row;
import :gmf_file;
import :gmf_binary;
import :gmf_ascii;
import :gmf_rows;
import :gmf_order;
import :gmf_raw;
import :gmf_blocks;
import :gmf_binary_writer;
import :gmf_ascii_writer;
import :vtu_arrays;
