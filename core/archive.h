#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/rigid_transform.h"

/// Values to bytes and back, exactly. A struct names its fields once, for both directions, in
///     template <class Archive> void Transfer(Archive& archive, X& x) { archive(x.a, x.b); }
/// in namespace backsight. The layout carries no description of itself: whoever keeps bytes keeps
/// beside them what program wrote them (io/artifact_store.h).
namespace backsight {

static_assert(std::endian::native == std::endian::little, "archives are little-endian");

/// Bytes that are no archive of the value that was asked for.
class DamagedArchive : public std::runtime_error {
 public:
  DamagedArchive() : std::runtime_error("the bytes end early or hold another value") {}
};

/// Counts the bytes that a value takes.
class ArchiveMeasure {
 public:
  static constexpr bool kReads = false;
  template <class... Values>
  void operator()(Values&... values) {
    (Transfer(*this, values), ...);
  }
  void Raw(const void*, std::size_t size) { bytes_ += size; }
  std::size_t bytes() const { return bytes_; }

 private:
  std::size_t bytes_ = 0;
};

class ArchiveWriter {
 public:
  static constexpr bool kReads = false;
  /// `bytes`: how many to expect.
  explicit ArchiveWriter(std::size_t bytes = 0) { bytes_.reserve(bytes); }
  template <class... Values>
  void operator()(Values&... values) {
    (Transfer(*this, values), ...);
  }
  void Raw(void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Hands the bytes on as they come: what is large by itself, without a copy, and the others in
/// pieces of 64 kB. `put` must outlive it.
class ArchiveStream {
 public:
  static constexpr bool kReads = false;
  using Put = std::function<void(std::string_view)>;
  explicit ArchiveStream(const Put& put) : put_(put) { piece_.reserve(kPiece); }
  explicit ArchiveStream(Put&&) = delete;
  template <class... Values>
  void operator()(Values&... values) {
    (Transfer(*this, values), ...);
  }
  void Raw(const void* data, std::size_t size) {
    if (piece_.size() + size > kPiece) Flush();
    const std::string_view bytes(static_cast<const char*>(data), size);
    if (size > kPiece) {
      put_(bytes);
    } else {
      piece_ += bytes;
    }
  }
  /// To be called at the end.
  void Flush() {
    put_(piece_);
    piece_.clear();
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{1} << 16U;
  const Put& put_;
  std::string piece_;
};

class ArchiveReader {
 public:
  static constexpr bool kReads = true;
  explicit ArchiveReader(std::string_view bytes) : bytes_(bytes) {}
  template <class... Values>
  void operator()(Values&... values) {
    (Transfer(*this, values), ...);
  }
  void Raw(void* data, std::size_t size) {
    if (size > bytes_.size()) throw DamagedArchive();
    std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  std::size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

template <class Archive, class Number>
requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
void Transfer(Archive& archive, Number& number) { archive.Raw(&number, sizeof(number)); }

/// How many elements follow; never more than the bytes that are left could hold.
template <class Archive>
std::size_t TransferCount(Archive& archive, std::size_t count) {
  std::uint64_t stored = count;
  Transfer(archive, stored);
  if constexpr (Archive::kReads) {
    if (stored > archive.left()) throw DamagedArchive();
  }
  return stored;
}

template <class Archive>
void Transfer(Archive& archive, std::string& text) {
  text.resize(TransferCount(archive, text.size()));
  archive.Raw(text.data(), text.size());
}

template <class Archive, class First, class Second>
void Transfer(Archive& archive, std::pair<First, Second>& pair) {
  archive(pair.first, pair.second);
}

template <class Archive, class Value>
void Transfer(Archive& archive, std::optional<Value>& value) {
  bool present = value.has_value();
  Transfer(archive, present);
  if constexpr (Archive::kReads) {
    value.reset();
    if (present) value.emplace();
  }
  if (present) Transfer(archive, *value);
}

template <class Archive, class Value, std::size_t kSize>
void Transfer(Archive& archive, std::array<Value, kSize>& values) {
  for (Value& value : values) Transfer(archive, value);
}

template <class Archive, class Value>
void Transfer(Archive& archive, std::vector<Value>& values) {
  values.resize(TransferCount(archive, values.size()));
  if constexpr (std::is_arithmetic_v<Value>) {
    archive.Raw(values.data(), values.size() * sizeof(Value));
  } else {
    for (Value& value : values) Transfer(archive, value);
  }
}

template <class Archive>
void Transfer(Archive& archive, std::vector<bool>& values) {
  std::vector<char> wide(values.begin(), values.end());
  Transfer(archive, wide);
  if constexpr (Archive::kReads) values.assign(wide.begin(), wide.end());
}

template <class Archive, class Scalar, int kRows, int kColumns, int... kMore>
void Transfer(Archive& archive, Eigen::Matrix<Scalar, kRows, kColumns, kMore...>& matrix) {
  if constexpr (kRows == Eigen::Dynamic || kColumns == Eigen::Dynamic) {
    const std::size_t rows = TransferCount(archive, static_cast<std::size_t>(matrix.rows()));
    const std::size_t columns = TransferCount(archive, static_cast<std::size_t>(matrix.cols()));
    if constexpr (Archive::kReads) {
      if (columns > 0 && rows > archive.left() / sizeof(Scalar) / columns) throw DamagedArchive();
      matrix.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
    }
  }
  archive.Raw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(Scalar));
}

template <class Archive>
void Transfer(Archive& archive, RigidTransform& transform) {
  archive(transform.rotation, transform.translation);
}

/// Fields are named once, for reading and writing; writing changes nothing.
template <class Archive, class Value>
void WriteTo(Archive& archive, const Value& value) {
  auto& fields = const_cast<Value&>(value);  // NOLINT(cppcoreguidelines-pro-type-const-cast)
  Transfer(archive, fields);
}

/// How many bytes a value takes.
template <class Value>
std::size_t SizeInBytes(const Value& value) {
  ArchiveMeasure measure;
  WriteTo(measure, value);
  return measure.bytes();
}

/// The bytes of a value.
template <class Value>
std::string ToBytes(const Value& value) {
  ArchiveWriter writer(SizeInBytes(value));
  WriteTo(writer, value);
  return writer.Take();
}

/// The same bytes, one piece after the other, some of which may be empty.
template <class Value>
void PutBytes(const Value& value, const ArchiveStream::Put& put) {
  ArchiveStream stream(put);
  WriteTo(stream, value);
  stream.Flush();
}

/// The value of bytes that ToBytes made of the same type. Throws DamagedArchive.
template <class Value>
Value FromBytes(std::string_view bytes) {
  ArchiveReader reader(bytes);
  Value value;
  Transfer(reader, value);
  if (reader.left() > 0) throw DamagedArchive();
  return value;
}

}  // namespace backsight
