module;
#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.commands;
import camber.core;
import camber.drawing;
import camber.run;
import :picture_words;

namespace camber::app {

namespace {

constexpr std::size_t most_pixels = 16384;  // along an edge

/// Numbers between commas; none where one of them is no number.
std::optional<std::vector<double>> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    for (;;) {
        const std::size_t comma = text.find(',');
        const std::string_view part = text.substr(0, comma);
        double x = 0;
        const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), x);
        if (error != std::errc{} || end != part.data() + part.size()) return {};
        numbers.push_back(x);
        if (comma == std::string_view::npos) return numbers;
        text.remove_prefix(comma + 1);
    }
}

auto no_such(std::string_view option, const std::string& text, std::string remedy) {
    return fail(ErrorKind::usage, in_quotes(text) + " is not understood", std::string(option), {}, std::move(remedy));
}

Outcome<Done> read_size(const std::string& text, run::PictureChoice& choice) {
    const std::size_t x = text.find('x');
    if (text.empty()) return Done{};
    const auto wide = numbers_in(std::string_view(text).substr(0, x));
    const auto high = x == std::string::npos ? std::nullopt : numbers_in(std::string_view(text).substr(x + 1));
    const auto is_sound = [](const std::optional<std::vector<double>>& n) {
        return n && n->size() == 1 && n->front() >= 16 && n->front() <= most_pixels;
    };
    if (!is_sound(wide) || !is_sound(high))
        return no_such("--size", text, "write WIDTHxHEIGHT in pixels, from 16 to 16384: 1200x900");
    choice.width = static_cast<std::size_t>(wide->front());
    choice.height = static_cast<std::size_t>(high->front());
    return Done{};
}

/// "x=0.5" and "x<0.5" keep what is below, "x>0.5" what is above; "a,b,c,d" keeps a x + b y + c z ≤ d.
Outcome<Done> read_cut(const std::string& text, run::PictureChoice& choice) {
    if (text.empty()) return Done{};
    const std::size_t axis = std::string_view("xyz").find(text[0]);
    if (axis != std::string_view::npos && text.size() > 2 &&
        std::string_view("=<>").find(text[1]) != std::string_view::npos) {
        const auto at = numbers_in(std::string_view(text).substr(2));
        if (at && at->size() == 1) {
            const double sign = text[1] == '>' ? -1 : 1;
            Cut<3> cut{{}, sign * at->front()};
            cut.normal[axis] = sign;
            choice.cut = cut;
            return Done{};
        }
    } else if (const auto n = numbers_in(text); n && n->size() == 4) {
        const Cut<3> cut{{{(*n)[0], (*n)[1], (*n)[2]}}, (*n)[3]};
        if (norm(cut.normal) > 0) {
            choice.cut = cut;
            return Done{};
        }
    }
    return no_such("--cut", text, "write x=0.5, or x>0.5 for the other side, or A,B,C,D: A x + B y + C z <= D stays");
}

Outcome<Done> read_view(const std::string& text, run::PictureChoice& choice) {
    if (text.empty()) return Done{};
    constexpr auto named = std::to_array<std::pair<std::string_view, Vec<3>>>({{"front", {{0, -1, 0}}},
                                                                               {"back", {{0, 1, 0}}},
                                                                               {"left", {{-1, 0, 0}}},
                                                                               {"right", {{1, 0, 0}}},
                                                                               {"top", {{0, 0, 1}}},
                                                                               {"bottom", {{0, 0, -1}}}});
    for (const auto& [name, from] : named)
        if (text == name) return choice.from = from, Done{};
    if (const auto n = numbers_in(text); n && n->size() == 3) {
        const Vec<3> from{{(*n)[0], (*n)[1], (*n)[2]}};
        if (norm(from) > 0) return choice.from = from, Done{};
    }
    return no_such("--view", text, "write front, back, left, right, top, bottom, or where you look from: 1,-1.6,0.9");
}

Outcome<Done> read_zoom(const std::string& text, run::PictureChoice& choice) {
    if (text.empty()) return Done{};
    if (auto n = numbers_in(text); n && (n->size() == 3 || n->size() == 4) && n->back() > 0) {
        const double radius = n->back();
        n->pop_back();
        n->resize(3);
        choice.zoom = PictureOptions::Zoom{{{(*n)[0], (*n)[1], (*n)[2]}}, radius};
        return Done{};
    }
    return no_such("--zoom", text, "write X,Y,Z,RADIUS, in 2D X,Y,RADIUS");
}

}  // namespace

Outcome<run::PictureChoice> choice_of(const PictureArguments& a) {
    run::PictureChoice choice;
    choice.colour = a.colour;
    choice.background = a.background;
    choice.edges = a.no_edges ? Edges::hidden : Edges::shown;
    choice.worst = static_cast<std::size_t>(a.worst);
    auto read = read_size(a.size, choice)
                    .and_then([&](Done) { return read_cut(a.cut, choice); })
                    .and_then([&](Done) { return read_view(a.view, choice); })
                    .and_then([&](Done) { return read_zoom(a.zoom, choice); });
    if (!read) return fail(read.error());
    return choice;
}

}  // namespace camber::app
