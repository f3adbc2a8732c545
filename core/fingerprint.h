#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace backsight {

/// Streaming content hash (XXH3, 128 bit) for change detection; not cryptographic.
class Fingerprint {
 public:
  Fingerprint();
  ~Fingerprint();
  Fingerprint(Fingerprint&&) noexcept;
  Fingerprint& operator=(Fingerprint&&) noexcept;

  void Add(std::span<const std::byte> bytes);
  /// Adds the length too, so that ("ab", "c") and ("a", "bc") differ.
  void Add(std::string_view text);
  void Add(std::uint64_t value);

  /// 32 lower-case hexadecimal digits.
  std::string Hex() const;
  std::uint64_t Value64() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Fingerprint of one text, in Hex().
std::string FingerprintText(std::string_view text);

/// Fingerprint of a file's bytes. Throws InputError if it cannot be read. `between`, called every
/// megabyte, may throw to give up.
std::string FingerprintFile(const std::string& path, const std::function<void()>& between = {});

}  // namespace backsight
