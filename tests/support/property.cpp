#include "property.hpp"

#include <cstdlib>
#include <sstream>
#include <string>

namespace camber::testing {

namespace {

template <class Testable>
void check(const std::string& name, const Testable& testable, const Trials& trials) {
    rc::detail::TestMetadata metadata;
    metadata.id = name;
    metadata.description = name;

    const bool configured = std::getenv("RC_PARAMS") != nullptr;
    const auto result = [&] {
        if (configured) return rc::detail::checkTestable(testable, metadata);
        rc::detail::TestParams params;
        std::uint64_t hash = 14695981039346656037U;  // FNV-1a
        for (const char letter : name) hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211U;
        params.seed = hash;
        params.maxSuccess = successes_here(trials.count);
        params.maxSize = trials.max_size;
        params.maxDiscardRatio = trials.max_discarded;
        return rc::detail::checkTestable(testable, metadata, params);
    }();

    std::ostringstream text;
    rc::detail::printResultMessage(result, text);
    const bool holds = result.template is<rc::detail::SuccessResult>();
    INFO(name << ": " << text.str());
    CHECK(holds);
}

}  // namespace

void check_property(const std::string& name, const Property& checked_property, const Trials& trials) {
    check(name, checked_property, trials);
}
void check_property(const std::string& name, const SeededProperty& checked_property, const Trials& trials) {
    check(name, checked_property, trials);
}

}  // namespace camber::testing
