/// The pipeline description of the program: its values, and their JSON text both ways, schema and explanations, all
/// from one description of each option.
export module camber.config;
export import :values;
export import :renames;
