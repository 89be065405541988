module camber.commands:picture_words;
import camber.core;
import camber.run;
import :picture_arguments;

namespace camber::app {

/// What the texts of the arguments mean. Errors: usage.
[[nodiscard]] Outcome<run::PictureChoice> choice_of(const PictureArguments& arguments);

}  // namespace camber::app
