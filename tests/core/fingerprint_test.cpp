#include "core/fingerprint.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "core/error.h"
#include "core/random.h"

namespace backsight {
namespace {

std::string RandomBytes(std::size_t n) {
  Random random(1);
  std::string bytes(n, '\0');
  for (char& c : bytes) c = static_cast<char>(random.Index(256));
  return bytes;
}

std::span<const std::byte> Bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

std::string HexOfTexts(std::initializer_list<std::string_view> texts) {
  Fingerprint fingerprint;
  for (const auto text : texts) fingerprint.Add(text);
  return fingerprint.Hex();
}

TEST(Fingerprint, DoesNotDependOnChunking) {
  const std::string bytes = RandomBytes(100000);
  Fingerprint whole;
  whole.Add(Bytes(bytes));
  for (const std::size_t chunk : {1U, 7U, 240U, 4096U}) {
    Fingerprint parts;
    for (std::size_t i = 0; i < bytes.size(); i += chunk) {
      parts.Add(Bytes(std::string_view(bytes).substr(i, chunk)));
    }
    EXPECT_EQ(parts.Hex(), whole.Hex()) << chunk;
    EXPECT_EQ(parts.Value64(), whole.Value64()) << chunk;
  }
}

TEST(Fingerprint, TextsCarryTheirLength) {
  EXPECT_NE(HexOfTexts({"ab", "c"}), HexOfTexts({"a", "bc"}));
  EXPECT_NE(HexOfTexts({"abc"}), HexOfTexts({"abc", ""}));
  EXPECT_EQ(HexOfTexts({"ab", "c"}), HexOfTexts({"ab", "c"}));
}

TEST(Fingerprint, EveryByteCounts) {
  std::string bytes = RandomBytes(2000);
  Fingerprint before;
  before.Add(Bytes(bytes));
  for (std::size_t i = 0; i < bytes.size(); i += 111) {
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
    Fingerprint after;
    after.Add(Bytes(bytes));
    EXPECT_NE(after.Hex(), before.Hex()) << i;
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
  }
}

TEST(Fingerprint, PrintsThirtyTwoHexDigits) {
  EXPECT_TRUE(std::regex_match(Fingerprint().Hex(), std::regex("[0-9a-f]{32}")));
  Fingerprint moved = [] {
    Fingerprint fingerprint;
    fingerprint.Add(std::uint64_t{17});
    return fingerprint;
  }();
  EXPECT_NE(moved.Hex(), Fingerprint().Hex());
}

TEST(Fingerprint, IsTheSameOnEveryMachine) {
  // Reference values of XXH3 with 128 bits and seed 0 for the empty input.
  EXPECT_EQ(Fingerprint().Hex(), "99aa06d3014798d86001c324468d497f");
}

class FingerprintFileTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(FingerprintFileTest, EqualsTheFingerprintOfItsBytes) {
  for (const std::size_t n : {0U, 1U, (1U << 20U), (1U << 20U) + 17U}) {
    const std::string bytes = RandomBytes(n);
    const std::string path = (folder_ / "data.bin").string();
    std::ofstream(path, std::ios::binary) << bytes;
    Fingerprint expected;
    expected.Add(Bytes(bytes));
    EXPECT_EQ(FingerprintFile(path), expected.Hex()) << n;
  }
}

TEST_F(FingerprintFileTest, RefusesWhatCannotBeRead) {
  const std::string missing = (folder_ / "missing.las").string();
  try {
    FingerprintFile(missing);
    FAIL() << "a missing file has no fingerprint";
  } catch (const InputError& error) {
    EXPECT_EQ(error.details().where, missing);
  }
  EXPECT_THROW(FingerprintFile(folder_.string()), InputError) << "a folder is no file";
}

}  // namespace
}  // namespace backsight
