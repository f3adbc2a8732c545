#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "io/e57/crc32c.h"
#include "io/e57/field_stream.h"
#include "io/e57/vector_section.h"
#include "io/e57/vector_writer.h"
#include "tests/io/e57/e57_bytes.h"
#include "tests/io/scan_files.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

/// Values of one field: integers as they are stored, floats as their bits.
struct FieldValues {
  E57Field field;
  std::vector<std::int64_t> integers;
  std::vector<double> reals;
};

std::int64_t RandomInteger(Random& random) {
  return std::bit_cast<std::int64_t>(random.Index(UINT64_MAX));
}

/// An integer field of exactly `bits` bits and values that include its bounds.
FieldValues IntegerValues(unsigned bits, std::size_t n, Random& random) {
  FieldValues values;
  values.field.name = "integer";
  values.field.type = random.Index(2) == 0 ? E57Type::kInteger : E57Type::kScaledInteger;
  // A span with its highest bit set takes `bits` bits.
  const std::uint64_t top = bits == 0 ? 0 : std::uint64_t{1} << (bits - 1);
  const std::uint64_t span = top == 0 ? 0 : top + random.Index(top);
  const std::uint64_t room = UINT64_MAX - span;
  const std::uint64_t above = room == 0 ? 0 : random.Index(room);
  constexpr auto kLowest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::min());
  values.field.minimum = static_cast<std::int64_t>(kLowest + above);
  values.field.maximum = static_cast<std::int64_t>(kLowest + above + span);
  for (std::size_t i = 0; i < n; ++i) {
    std::uint64_t value = span == UINT64_MAX ? random.Index(UINT64_MAX) : random.Index(span + 1);
    if (i % 7 == 0) value = span;
    if (i % 11 == 0) value = 0;
    values.integers.push_back(static_cast<std::int64_t>(kLowest + above + value));
  }
  return values;
}

FieldValues RealValues(E57Type type, std::size_t n, Random& random) {
  FieldValues values;
  values.field.name = type == E57Type::kSingle ? "single" : "double";
  values.field.type = type;
  for (std::size_t i = 0; i < n; ++i) {
    // Any bits but those of NaN, whose bits need not survive a conversion.
    const auto bits = std::bit_cast<std::uint64_t>(RandomInteger(random));
    double value = type == E57Type::kSingle
                       ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                       : std::bit_cast<double>(bits);
    if (std::isnan(value)) value = i % 2 == 0 ? INFINITY : -0.0;
    values.reals.push_back(value);
  }
  return values;
}

/// Writes the records as one section after `before` bytes; returns the section's place.
E57VectorPlace WriteSection(const std::string& path, const std::vector<FieldValues>& columns,
                            std::size_t n, std::size_t before) {
  PagedWriter out(path);
  out.Reserve(kE57HeaderBytes);
  out.Write(std::string(before, 'x'));
  std::vector<E57Field> fields;
  for (const FieldValues& column : columns) fields.push_back(column.field);
  VectorWriter writer(out, fields);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (columns[k].field.IsInteger()) {
        writer.Put(k, columns[k].integers[i]);
      } else {
        writer.Put(k, columns[k].reals[i]);
      }
    }
    writer.EndRecord();
  }
  EXPECT_EQ(writer.Finish(), n);
  std::string header = "ASTM-E57";
  Append(header, std::uint64_t{1});
  Append(header, out.PhysicalBytes());
  Append(header, std::uint64_t{0});
  Append(header, std::uint64_t{0});
  Append(header, kE57PageBytes);
  out.Fill(0, header);
  out.Commit();
  return {writer.file_offset(), n, 0};
}

void ExpectReadBack(const std::string& path, const E57VectorPlace& place,
                    const std::vector<FieldValues>& columns, Random& random) {
  PagedFile file(path);
  std::vector<E57Field> fields;
  for (const FieldValues& column : columns) fields.push_back(column.field);
  VectorSection section(file, place, fields);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    FieldStream stream(section, fields[k], k);
    // In pieces of odd sizes, as no reader would ask for them.
    for (std::size_t at = 0; at < place.record_count;) {
      const std::size_t n = std::min<std::size_t>(1 + random.Index(3000), place.record_count - at);
      if (columns[k].field.IsInteger()) {
        std::vector<std::int64_t> read(n);
        stream.Read(std::span(read));
        ASSERT_TRUE(std::equal(read.begin(), read.end(), &columns[k].integers[at]))
            << fields[k].name;
      } else {
        std::vector<double> read(n);
        stream.Read(std::span(read));
        for (std::size_t i = 0; i < n; ++i) {
          ASSERT_EQ(std::bit_cast<std::uint64_t>(read[i]),
                    std::bit_cast<std::uint64_t>(columns[k].reals[at + i]));
        }
      }
      at += n;
    }
  }
}

TEST(Crc32c, IsThatOfRfc3720) {
  EXPECT_EQ(Crc32c("123456789"), 0xE3069283U);
  EXPECT_EQ(Crc32c(std::string(32, '\0')), 0x8A9136AAU);
  EXPECT_EQ(Crc32c(""), 0U);
  Random random(1);
  for (std::size_t n = 0; n < 300; n += 7) {
    std::string bytes(n, '\0');
    for (char& c : bytes) c = static_cast<char>(random.Index(256));
    EXPECT_EQ(Crc32c(bytes), TableCrc32c(bytes));
  }
}

TEST(VectorCodec, EveryBitWidthIsReadBackExactly) {
  const TempDir dir;
  for (unsigned bits = 0; bits <= 64; ++bits) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      Random random(100 * bits + seed);
      const std::size_t n = seed == 0 ? random.Index(10) : random.Index(20'000);
      const std::vector<FieldValues> columns{IntegerValues(bits, n, random)};
      ASSERT_EQ(columns[0].field.Bits(), bits);
      const std::string path = dir / "a.e57";
      const auto place = WriteSection(path, columns, n, random.Index(3000));
      ExpectReadBack(path, place, columns, random);
    }
  }
}

TEST(VectorCodec, RecordsOfManyFieldsAreReadBackExactly) {
  const TempDir dir;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const std::size_t n = random.Index(8000);
    std::vector<FieldValues> columns;
    for (std::uint64_t k = 1 + random.Index(12); k > 0; --k) {
      const std::uint64_t kind = random.Index(4);
      if (kind < 2) {
        columns.push_back(IntegerValues(static_cast<unsigned>(random.Index(65)), n, random));
      } else {
        columns.push_back(RealValues(kind == 2 ? E57Type::kSingle : E57Type::kDouble, n, random));
      }
    }
    const std::string path = dir / "a.e57";
    const auto place = WriteSection(path, columns, n, random.Index(3000));
    ExpectReadBack(path, place, columns, random);
  }
}

TEST(VectorCodec, ValuesBeyondTheirFieldAreTheCallersFault) {
  const TempDir dir;
  PagedWriter out(dir / "a.e57");
  VectorWriter writer(out, {{.name = "i", .type = E57Type::kInteger, .minimum = -2, .maximum = 3},
                            {.name = "d", .type = E57Type::kDouble}});
  EXPECT_THROW(writer.Put(0, std::int64_t{4}), InternalError);
  EXPECT_THROW(writer.Put(0, std::int64_t{-3}), InternalError);
  EXPECT_THROW(writer.Put(0, 1.0), InternalError);
  EXPECT_THROW(writer.Put(1, std::int64_t{1}), InternalError);
}

TEST(VectorCodec, ASectionEndsWithAnIndexPacketForItsFirstData) {
  const TempDir dir;
  Random random(3);
  const std::vector<FieldValues> columns{IntegerValues(40, 20'000, random)};
  const std::string path = dir / "a.e57";
  const auto place = WriteSection(path, columns, 20'000, 5);
  const std::string payload = Payload(ReadBytes(path));
  const std::uint64_t start = E57Logical(place.file_offset);
  EXPECT_EQ(start % 4, 0U);
  const auto number = [&](std::uint64_t at) { return LoadBytes<std::uint64_t>(&payload[at]); };
  EXPECT_EQ(number(start), 1U);
  const std::uint64_t index = E57Logical(number(start + 24));
  EXPECT_EQ(index + 32, start + number(start + 8));
  EXPECT_EQ(number(index), 0x1001F0000U);  // index packet of 32 bytes, one entry
  EXPECT_EQ(number(index + 16), 0U);       // of record 0
  EXPECT_EQ(number(index + 24), number(start + 16));
}

}  // namespace
}  // namespace backsight
