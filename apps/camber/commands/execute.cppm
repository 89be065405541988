module;
#include <functional>
#include <string>
module camber.commands:execute;
import camber.core;
import camber.config;
import camber.io;
import camber.run;
import :ending;
import :given;

namespace camber::app {

/// An error that says no place, as one of that file.
Error of_file(Error error, const std::string& path);

/// A file's mesh, by its content; a flat one as a plane mesh in 2D with its lift, and a notice of that, or as a
/// surface.
Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat, const DecodeOptions& options,
                               const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat,
                                                    const Execution& execution) {
    return read_mesh(path, flat, {}, execution);
}

/// A solution file for a mesh that was read: of a flat one's in space, what it says of directions in the plane.
Outcome<DecodedSolution> read_solution_for(const DecodedMesh& mesh, const std::string& path,
                                           const Execution& execution);

/// What a config's geometry is in files for: a CAD model, another mesh, unless that is given.
Outcome<run::GeometrySource> read_geometry(const config::Geometry& geometry, const Execution& execution,
                                           const Given& given = {});

/// A pipeline as the mesh that it begins with asks for.
using Fit = std::function<Outcome<config::Pipeline>(config::Pipeline, const AnyMesh&)>;

/// The whole run of a config: reads or generates, runs the stages with clocks and progress, writes the outputs
/// and adds them to those written. `fit`, if there is one, is asked once the input is read. Outputs with names of
/// values in memory are not written: the run has them.
Outcome<run::Run> execute(const config::Pipeline& pipeline, Written& written, const Fit& fit = {}, Host host = {});

/// What `execute` would do, as text: reads or generates the input, checks the outputs, writes nothing.
Outcome<std::string> plan(const config::Pipeline& pipeline, const Fit& fit = {});

/// Whether all outputs can be written. Errors: usage, an ending; write.
Outcome<Done> check_outputs(const config::Output& output);

}  // namespace camber::app
