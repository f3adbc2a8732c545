#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace backsight {

/// Splits `line` at `separator`; fields are trimmed of blanks and tabs. A separator of ' ' means
/// any run of blanks and tabs; with others an empty last field (a trailing separator) does not
/// count. Fills at most fields.size() and returns how many fields there are, which may be more.
std::size_t SplitFields(std::string_view line, char separator, std::span<std::string_view> fields);

/// The whole of `text` as a decimal number (nan and inf included), or nothing.
std::optional<double> ParseNumber(std::string_view text);

/// The whole of `text` as an unsigned integer, or nothing (sign, fraction, overflow).
std::optional<std::uint64_t> ParseCount(std::string_view text);

std::string_view Trim(std::string_view text);
std::string ToLower(std::string_view text);

/// `text` for an error message: quoted, shortened, unprintable bytes escaped.
std::string Quoted(std::string_view text);

}  // namespace backsight
