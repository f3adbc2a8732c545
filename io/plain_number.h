#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace backsight {

/// Reads a decimal number without exponent at `at` and steps behind it. The value is that of
/// ParseNumber: digits up to 2^53 and powers of ten are exact, so that their quotient is rounded
/// once (Clinger 1990, doi 10.1145/93542.93557). Nothing for whatever else stands there, numbers of
/// more digits and other forms among it; `at` then means nothing. The text must hold a byte that is
/// neither digit nor point behind it.
inline std::optional<double> TakePlainNumber(const char*& at) {
  constexpr std::array<double, 20> kPowers{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,
                                           1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13,
                                           1e14, 1e15, 1e16, 1e17, 1e18, 1e19};
  constexpr std::uint64_t kMostExact = std::uint64_t{1} << 53U;
  constexpr int kMostDigits = 19;  // that never overflow
  std::uint64_t value = 0;
  const auto take_digits = [&] {
    const char* const first = at;
    for (; *at >= '0' && *at <= '9'; ++at) value = 10 * value + static_cast<unsigned>(*at - '0');
    return at - first;
  };
  const bool negative = *at == '-';
  if (negative) ++at;
  const auto whole = take_digits();
  if (whole == 0) return std::nullopt;
  std::ptrdiff_t decimals = 0;
  if (*at == '.') {
    ++at;
    decimals = take_digits();
    if (decimals == 0) return std::nullopt;
  }
  if (whole + decimals > kMostDigits || value > kMostExact) return std::nullopt;
  const double magnitude = static_cast<double>(value) / kPowers[static_cast<std::size_t>(decimals)];
  return negative ? -magnitude : magnitude;
}

}  // namespace backsight
