module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>
/// Pipelines as JSON: reading, writing, schema and explanations, all from one description of each option.
export module camber.config;
import camber.core;
import camber.recipes;
import camber.reports;
export import :renames;

export namespace camber::config {

/// Reads a pipeline. `name` is the file name for errors. An override is `path=value`. The path has keys and indices
/// from 0 (`stages/1/curve/objective`), or a stage's verb (`stages/curve/objective`). The value is JSON or a word.
/// Errors: usage; syntax with line and column, and unknown or duplicate keys, wrong types and values out of range with
/// their path.
[[nodiscard]] Outcome<Pipeline> read_pipeline(std::string_view text, std::string_view name,
                                              std::span<const std::string> overrides = {});

/// Applies overrides as in `read_pipeline`.
[[nodiscard]] Outcome<Pipeline> with_values(const Pipeline& pipeline, std::span<const std::string> overrides,
                                            std::string_view name);

/// Reads a section from JSON or a word (`natural`, `surrogate`). For a metric, other text is a file path.
[[nodiscard]] Outcome<Metric> read_metric(std::string_view text, std::string_view name);
[[nodiscard]] Outcome<Geometry> read_geometry(std::string_view text, std::string_view name);

/// Reads a shape: a name, JSON such as {"shell": {…}}, or a pipeline with a generated input. Overrides set options of
/// the shape: `inner_layer/count=3`.
[[nodiscard]] Outcome<Shape> read_shape(std::string_view text, std::string_view name,
                                        std::span<const std::string> overrides = {});
[[nodiscard]] std::string name_of(const Shape& shape);

/// Writes all defaults too; `read_pipeline` restores the same value.
[[nodiscard]] std::string write_pipeline(const Pipeline& pipeline);

[[nodiscard]] run::PipelineTexts parts_of(const Pipeline& pipeline);

/// JSON Schema (draft 2020-12) of a config.
[[nodiscard]] std::string pipeline_schema();

[[nodiscard]] std::vector<std::string> topics();

struct TopicGroup {
    std::string title;
    std::vector<std::string> topics;
};
[[nodiscard]] std::vector<TopicGroup> topic_groups();

/// Errors: usage; an unknown topic, with the nearest one.
[[nodiscard]] Outcome<std::string> explain(std::string_view topic);

/// At most `most` candidates that are similar to the word or contain it, best first.
[[nodiscard]] std::vector<std::string> nearest_words(std::string_view word, const std::vector<std::string>& candidates,
                                                     std::size_t most = 3);
[[nodiscard]] std::string alternatives_text(const std::vector<std::string>& words);

/// Makes relative input paths relative to the folder of the config. Output paths do not change.
[[nodiscard]] Pipeline with_inputs_below(Pipeline pipeline, std::string_view folder);

}  // namespace camber::config
