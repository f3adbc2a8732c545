#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "core/error.h"
#include "core/random.h"
#include "io/scan_reader.h"
#include "tests/io/append_bytes.h"

namespace backsight {

/// A directory of its own for each test, removed with all it holds.
class TempDir {
 public:
  TempDir() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "_" + test->name();
    std::replace(name.begin(), name.end(), '/', '_');  // parameterised tests have one
    const auto now = std::filesystem::file_time_type::clock::now().time_since_epoch().count();
    path_ =
        std::filesystem::temp_directory_path() / ("backsight_" + name + "_" + std::to_string(now));
    std::filesystem::create_directories(path_);
  }
  ~TempDir() { std::filesystem::remove_all(path_); }
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

  std::size_t FileCount() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

  /// Writes a file and returns its path.
  std::string File(const std::string& name, std::string_view bytes) const {
    const std::string file = *this / name;
    std::ofstream(file, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
  }

 private:
  std::filesystem::path path_;
};

inline std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct WholeScan {
  ScanInfo info;
  ScanTally tally;
  PointChunk points;
  std::size_t chunks = 0;
};

/// Reads a scan to its end and checks what every reader promises.
inline WholeScan ReadWhole(const std::string& path, int scan_index = 0,
                           const TextColumns& columns = {}) {
  const auto reader = OpenScan(path, scan_index, columns);
  WholeScan scan;
  PointChunk chunk;
  while (reader->Next(chunk)) {
    ++scan.chunks;
    EXPECT_LE(chunk.size(), 65536U);
    EXPECT_EQ(chunk.y.size(), chunk.size());
    EXPECT_EQ(chunk.z.size(), chunk.size());
    EXPECT_EQ(chunk.intensity.size(), reader->info().has_intensity ? chunk.size() : 0U);
    EXPECT_EQ(chunk.rgb.size(), reader->info().has_rgb ? chunk.size() : 0U);
    EXPECT_EQ(chunk.classification.size(), reader->info().has_classification ? chunk.size() : 0U);
    EXPECT_EQ(chunk.gps_time.size(), reader->info().has_gps_time ? chunk.size() : 0U);
    EXPECT_EQ(chunk.row.size(), reader->info().rows > 0 ? chunk.size() : 0U);
    EXPECT_EQ(chunk.column.size(), chunk.row.size());
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(scan.points.x, chunk.x);
    append(scan.points.y, chunk.y);
    append(scan.points.z, chunk.z);
    append(scan.points.intensity, chunk.intensity);
    append(scan.points.rgb, chunk.rgb);
    append(scan.points.classification, chunk.classification);
    append(scan.points.gps_time, chunk.gps_time);
    append(scan.points.row, chunk.row);
    append(scan.points.column, chunk.column);
  }
  EXPECT_FALSE(reader->Next(chunk));
  EXPECT_TRUE(chunk.empty());
  scan.info = reader->info();
  scan.tally = reader->tally();
  EXPECT_EQ(scan.tally.points, scan.points.size());
  EXPECT_EQ(scan.tally.records,
            scan.tally.points + scan.tally.not_finite + scan.tally.no_return + scan.tally.withheld);
  return scan;
}

/// Runs `body` and returns the message of the InputError it must throw.
template <typename Body>
std::string ErrorOf(const Body& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return "";
}

inline std::string ReadError(const std::string& path, int scan_index = 0) {
  return ErrorOf([&] { ReadWhole(path, scan_index); });
}

/// Damages `bytes` in many ways; reading must end in a scan or an InputError, never otherwise.
inline void ExpectSafeWhenDamaged(const std::string& bytes, const std::string& name,
                                  int rounds = 150) {
  const TempDir dir;
  const auto attempt = [&](const std::string& damaged) {
    const std::string path = dir.File(name, damaged);
    try {
      ReadWhole(path);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  for (std::size_t n = 0; n <= bytes.size(); n += 1 + bytes.size() / 100) {
    attempt(bytes.substr(0, n));
  }
  for (int seed = 0; seed < rounds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    std::string damaged = bytes;
    const std::uint64_t hits = 1 + random.Index(8);
    for (std::uint64_t i = 0; i < hits; ++i) {
      damaged[random.Index(damaged.size())] = static_cast<char>(random.Index(256));
    }
    attempt(damaged);
    const std::size_t at = random.Index(bytes.size());
    attempt(bytes.substr(0, at) + std::to_string(random.Index(UINT64_MAX)) + bytes.substr(at));
  }
}

}  // namespace backsight
