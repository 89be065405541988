module;
#include <span>
#include <string>
#include <string_view>
#include <vector>
export module camber.config:text;
import camber.core;
import :values;

export namespace camber::config {

/// The pipeline that a JSON text describes; `name` (the file's) goes into errors. `overrides` are `path=value`: a path
/// of keys and positions from 0 with slashes (`stages/1/curve/objective`; a stage also by its verb,
/// `stages/curve/objective`), a value in JSON or a bare word.
/// Errors (usage): syntax with line and column; duplicate and unknown keys, wrong types and values out of range with
/// their JSON path.
[[nodiscard]] Outcome<Pipeline> read_pipeline(std::string_view text, std::string_view name,
                                              std::span<const std::string> overrides = {});

/// One part alone, as an argument gives it: JSON, a bare word of the part's own (`natural`, `surrogate`), and for a
/// metric else a file's path.
[[nodiscard]] Outcome<Metric> read_metric(std::string_view text, std::string_view name);
[[nodiscard]] Outcome<Geometry> read_geometry(std::string_view text, std::string_view name);

/// A shape to generate, as an argument or a file gives it: its name, JSON such as {"shell": {…}}, or a whole pipeline
/// whose input is generated. `overrides` are `path=value` among the shape's options (`inner_layer/count=3`).
[[nodiscard]] Outcome<Shape> read_shape(std::string_view text, std::string_view name,
                                        std::span<const std::string> overrides = {});
/// The word of a shape: shell, annulus …
[[nodiscard]] std::string name_of(const Shape& shape);

/// The whole pipeline with every default, as JSON; `read_pipeline` of it gives the same value.
[[nodiscard]] std::string write_pipeline(const Pipeline& pipeline);

/// The parts of a pipeline as JSON in one line. Stages contain the options that differ from the defaults.
struct Parts {
    std::string input, metric, geometry;
    std::vector<std::string> metric_operations, stages;
};
[[nodiscard]] Parts parts_of(const Pipeline& pipeline);

/// JSON Schema (draft 2020-12) of a config, for editors.
[[nodiscard]] std::string pipeline_schema();

/// What `explain` knows: pipeline, the stages, sources of mesh, metric and geometry.
[[nodiscard]] std::vector<std::string> topics();

/// A topic's meaning and options: names, types, defaults, units. Error (usage): unknown topic, with the nearest.
[[nodiscard]] Outcome<std::string> explain(std::string_view topic);

/// The same pipeline with its relative input paths (mesh, metric file) put below the folder: a config finds its data
/// beside it, wherever the program is started. Outputs stay relative to the working directory.
[[nodiscard]] Pipeline with_inputs_below(Pipeline pipeline, std::string_view folder);

}  // namespace camber::config
