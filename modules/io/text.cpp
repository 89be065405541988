module;
#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>
#include <system_error>
module camber.io;

namespace camber {

std::string line_place(std::string_view name, std::string_view text, const char* at) {
    return std::string(name) + ": line " + std::to_string(std::count(text.data(), at, '\n') + 1);
}

bool read_unusual_real(std::string_view word, double& value) {
    std::string text(word.starts_with('+') ? word.substr(1) : word);
    for (char& c : text)
        if (c == 'd' || c == 'D') c = 'e';
    // The wider exponent of long double tells what is too large (infinite) from what is too small (0).
    long double wide = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), wide);
    value = static_cast<double>(wide);
    return !text.empty() && error == std::errc{} && stop == text.data() + text.size();
}

}  // namespace camber
