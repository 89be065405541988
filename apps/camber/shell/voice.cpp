module;
module camber.app_shell;

namespace camber::app {

namespace {

Voice of_program = Voice::usual;

}  // namespace

void set_voice(Voice voice) {
    if (of_program != Voice::none) of_program = voice;
}
Voice voice() { return of_program; }

}  // namespace camber::app
