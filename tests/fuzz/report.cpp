#include "targets.hpp"

#include <algorithm>
#include <string>

import camber.recipes;
import camber.reports;

namespace fuzz {

void report(Bytes bytes) {
    std::string text(bytes.size(), '\0');
    std::transform(bytes.begin(), bytes.end(), text.begin(), [](std::byte b) { return static_cast<char>(b); });
    const auto histograms = camber::run::histograms_of_report(text);
    if (!histograms) return;
    expect(!histograms->empty(), "a report has histograms");
    for (const auto& histogram : *histograms) {
        expect(camber::run::svg(histogram).ends_with("</svg>\n"), "a histogram can be drawn");
        expect(!camber::run::bars(histogram).empty(), "a histogram can be printed");
    }
}

}  // namespace fuzz
