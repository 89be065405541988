module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>
/// JSON text of pipelines: reading, writing, schema and explanations, all from one description of each option.
export module camber.config;
import camber.core;
import camber.recipes;
import camber.reports;
export import :renames;

export namespace camber::config {

/// The pipeline that a JSON text describes; `name` (the file's) goes into errors. `overrides` are `path=value`: a path
/// of keys and positions from 0 with slashes (`stages/1/curve/objective`; a stage also by its verb,
/// `stages/curve/objective`), a value in JSON or a bare word.
/// Errors (usage): syntax with line and column; duplicate and unknown keys, wrong types and values out of range with
/// their JSON path.
[[nodiscard]] Outcome<Pipeline> read_pipeline(std::string_view text, std::string_view name,
                                              std::span<const std::string> overrides = {});

/// The pipeline with other values, as `overrides` of read_pipeline; also checks all values by their limits.
[[nodiscard]] Outcome<Pipeline> with_values(const Pipeline& pipeline, std::span<const std::string> overrides,
                                            std::string_view name);

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

/// Returns the parts of a pipeline as JSON in one line.
[[nodiscard]] run::PipelineTexts parts_of(const Pipeline& pipeline);

/// JSON Schema (draft 2020-12) of a config, for editors.
[[nodiscard]] std::string pipeline_schema();

/// Topics that `explain` knows: pipeline, the stages, sources of mesh, metric and geometry.
[[nodiscard]] std::vector<std::string> topics();

/// Topics of one kind.
struct TopicGroup {
    std::string title;
    std::vector<std::string> topics;
};
/// Returns all topics by kind: stages, shapes, metrics, geometries, and the sections of a config.
[[nodiscard]] std::vector<TopicGroup> topic_groups();

/// A topic's meaning and options: names, types, defaults, units. Error (usage): unknown topic, with the nearest.
[[nodiscard]] Outcome<std::string> explain(std::string_view topic);

/// Returns the candidates that are most like the word, best first, at most `most`: those at a small edit distance, that
/// begin with it or contain it.
[[nodiscard]] std::vector<std::string> nearest_words(std::string_view word, const std::vector<std::string>& candidates,
                                                     std::size_t most = 3);
/// Returns `"a", "b" or "c"`.
[[nodiscard]] std::string alternatives_text(const std::vector<std::string>& words);

/// The same pipeline with its relative input paths (mesh, metric file) put below the folder: a config finds its data
/// beside it, wherever the program is started. Outputs stay relative to the working directory.
[[nodiscard]] Pipeline with_inputs_below(Pipeline pipeline, std::string_view folder);

}  // namespace camber::config
