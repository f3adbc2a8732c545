#include "io/utf8.h"

#include <algorithm>

namespace backsight {

std::size_t Utf8Length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char c = byte(at);
  if (c < 0x80U) {
    const bool printable = c >= 0x20U && c != 0x7FU;
    return printable || c == '\t' || c == '\n' || c == '\r' ? 1 : 0;
  }
  const std::size_t length = c >= 0xF0U ? 4 : c >= 0xE0U ? 3 : 2;
  if (c < 0xC2U || c > 0xF4U || at + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(at + k) & 0xC0U) != 0x80U) return 0;
  }
  const unsigned char second = byte(at + 1);
  const bool overlong = (c == 0xE0U && second < 0xA0U) || (c == 0xF0U && second < 0x90U);
  const bool surrogate = c == 0xEDU && second > 0x9FU;
  const bool beyond = c == 0xF4U && second > 0x8FU;
  return overlong || surrogate || beyond ? 0 : length;
}

std::string CleanUtf8(std::string_view text) {
  std::string clean;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = Utf8Length(text, at);
    clean += length == 0 ? "?" : text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return clean;
}

}  // namespace backsight
