module;
#include <optional>
#include <string>
export module camber.commands:picture_arguments;
import camber.config;
import camber.drawing;
import camber.run;

export namespace camber::app {

/// A mesh as a picture.
struct PictureArguments {
    std::string input, output;
    std::string size, cut, view, zoom;    ///< "1200x900"; "x=0.5"; "top", "1,-2,1"; "X,Y,Z,RADIUS"; empty: the usual
    std::string metric, solution, field;  ///< files, and the name of a field of the latter; empty: none, the first
    std::optional<run::PictureColour> colour = {};
    Background background = Background::light;
    bool no_edges = false;
    int worst = 0;
    config::Flat flat = config::Flat::plane;
    int threads = 0;
};
[[nodiscard]] int picture_command(const PictureArguments& arguments);

}  // namespace camber::app
