// Reduction of tests under the sanitizers, which are ten times slower. Their findings appear in few of many similar
// inputs; the release build runs all.
#pragma once

namespace camber::testing {

#if __has_feature(address_sanitizer)
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif

/// Returns `all`, or `less` under the sanitizers.
template <class T>
[[nodiscard]] constexpr T less_if_sanitized(T all, T less) {
    return is_sanitized ? less : all;
}

}  // namespace camber::testing
