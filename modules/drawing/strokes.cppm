module;
#include <array>
#include <cctype>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>
module camber.drawing:strokes;

/// A small alphabet of strokes: digits, small letters, a few signs and the J of Jacobian.
namespace camber {

struct StrokePoint {
    double x, y;  ///< to the right and up from the base line, in sixths of a capital letter
};
using Stroke = std::vector<StrokePoint>;

/// Each letter's strokes one after the other, by points of two signs: x and y; a and b are one and two below the base
/// line. A stroke of one point is a dot.
constexpr auto letters = std::to_array<std::pair<char, std::string_view>>({
    {'0', "103041453616050110"},
    {'1', "052620 1030"},
    {'2', "05163645440040"},
    {'3', "051636454433 133342413010 01"},
    {'4', "30360242"},
    {'5', "460603334241301001"},
    {'6', "453616050110304142331302"},
    {'7', "064610"},
    {'8', "133344453616050413 130201103041423313"},
    {'9', "011030414536160504133344"},
    {'.', "0000"},
    {'-', "0333"},
    {'+', "0343 2125"},
    {'_', "0040"},
    {'/', "0046"},
    {',', "100a"},
    {'(', "26151120"},
    {')', "06151100"},
    {'=', "0242 0444"},
    {':', "0101 0404"},
    {'J', "4641301001"},
    {'a', "04344340 421201103041"},
    {'b', "0600 0314344341301001"},
    {'c', "4334140301103041"},
    {'d', "4640 4334140301103041"},
    {'e', "02424334140301103041"},
    {'f', "36261510 0434"},
    {'g', "444a3b0b 4334140301103041"},
    {'h', "0600 0314344340"},
    {'i', "0004 0606"},
    {'j', "141a0b 1616"},
    {'k', "0600 340230"},
    {'l', "0600"},
    {'m', "0400 0314243330 3344546360"},
    {'n', "0400 0314344340"},
    {'o', "103041433414030110"},
    {'p', "040b 0314344341301001"},
    {'q', "444b 4334140301103041"},
    {'r', "0400 031434"},
    {'s', "43341403123241301001"},
    {'t', "16112030 0434"},
    {'u', "0401103041 4440"},
    {'v', "042044"},
    {'w', "0410243044"},
    {'x', "0440 0044"},
    {'y', "0420 440b"},
    {'z', "04440040"},
});

/// A text as strokes, and how far it goes.
struct StrokedText {
    std::vector<Stroke> strokes;
    double width = 0;
};

inline StrokedText stroked(std::string_view text) {
    constexpr double between = 1.8, space = 3;
    StrokedText out;
    for (const char given : text) {
        const char c = given == 'J' ? given : static_cast<char>(std::tolower(static_cast<unsigned char>(given)));
        double width = 0;
        bool is_known = false;
        for (const auto& [letter, points] : letters) {
            if (letter != c) continue;
            is_known = true;
            out.strokes.emplace_back();
            for (std::size_t i = 0; i < points.size();) {
                if (points[i] == ' ') {
                    out.strokes.emplace_back();
                    ++i;
                    continue;
                }
                const double x = points[i] - '0';
                const double y = points[i + 1] >= 'a' ? 'a' - 1 - points[i + 1] : points[i + 1] - '0';
                out.strokes.back().push_back({out.width + x, y});
                width = x > width ? x : width;
                i += 2;
            }
        }
        out.width += is_known ? width + between : space;
    }
    return out;
}

}  // namespace camber
