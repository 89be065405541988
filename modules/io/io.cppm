/// Meshes and solutions to and from bytes; the table of formats, one row each; flat meshes to 2D and back. Nothing here
/// touches files: the shell reads and writes them.
export module camber.io;
export import :any_mesh;
export import :solution;
export import :gmf;
export import :mesh_fields;
export import :flat;
export import :vtu;
export import :formats;
// The partitions below export no names: they are the parts that readers and writers are made of.
export import :gmf_keywords;
export import :gmf_row;
export import :gmf_file;
export import :gmf_binary;
export import :gmf_ascii;
export import :gmf_rows;
export import :gmf_order;
export import :gmf_raw;
export import :gmf_blocks;
export import :gmf_binary_writer;
export import :gmf_ascii_writer;
export import :vtu_arrays;
