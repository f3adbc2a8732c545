#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace backsight {

/// `text` with &, <, >, " and ' as entities, and control characters and bytes that are not UTF-8
/// as U+FFFD: safe as element content and in quoted attributes.
std::string HtmlText(std::string_view text);

/// `value` with a fixed number of decimals. Throws InternalError naming `field` if not finite.
std::string FixedText(double value, int decimals, std::string_view field);

/// 12345678 as "12 345 678", with no-break spaces.
std::string GroupedText(std::uint64_t value);

std::string Base64(std::span<const std::uint8_t> bytes);

}  // namespace backsight
