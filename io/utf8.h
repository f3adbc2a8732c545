#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace backsight {

/// Number of bytes of the UTF-8 character that begins at text[at]; 0 if there is none (a stray
/// byte, an overlong form, a surrogate) or if it is a control character other than tab, line feed
/// and carriage return.
std::size_t Utf8Length(std::string_view text, std::size_t at);

/// The text with '?' for every byte that begins no such character: fit for messages and reports.
std::string CleanUtf8(std::string_view text);

}  // namespace backsight
