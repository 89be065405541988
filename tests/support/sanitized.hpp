// What tests do less of under the sanitizers, which make all ten times as long: what they look for shows in few of many
// inputs that are alike. The release build does all.
#pragma once

namespace camber::testing {

#if __has_feature(address_sanitizer)
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif

/// `all`, or `less` under the sanitizers.
template <class T>
[[nodiscard]] constexpr T less_if_sanitized(T all, T less) {
    return is_sanitized ? less : all;
}

}  // namespace camber::testing
