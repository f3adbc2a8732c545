#include "io/e57/paged_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "io/e57/crc32c.h"
#include "io/endian_bytes.h"
#include "io/text_fields.h"

namespace backsight {
namespace {

constexpr std::string_view kSignature = "ASTM-E57";
constexpr const char* kRemedy = "the E57 file is damaged: copy or export it again";

}  // namespace

PagedFile::PagedFile(const std::string& path) : source_(path) { ReadHeader(); }

void PagedFile::ReadHeader() {
  const std::string_view start = source_.Peek(kE57PageBytes);
  if (!start.starts_with(kSignature)) {
    throw source_.Error(0, Quoted(start.substr(0, kSignature.size())), "'ASTM-E57'",
                        "check that this is an E57 file");
  }
  // A file below one page must not pass for a file of no pages.
  header_.physical_bytes = kE57PageBytes;
  std::array<char, kE57HeaderBytes> bytes{};
  Read(0, bytes.data(), bytes.size(), "bytes of the file header");
  const auto number = [&bytes](std::size_t at) { return LoadBytes<std::uint64_t>(&bytes[at]); };
  const auto major = LoadBytes<std::uint32_t>(&bytes[8]);
  if (major != 1) throw Error(8, fmt::format("format version {}", major), "version 1");
  if (number(40) != kE57PageBytes) {
    throw Error(40, fmt::format("pages of {} bytes", number(40)), "pages of 1024 bytes");
  }
  const std::uint64_t declared = number(16);
  if (declared > source_.size()) {
    throw source_.Truncated(source_.size(), "bytes", declared, source_.size());
  }
  if (declared == 0 || declared % kE57PageBytes != 0) {
    throw Error(16, fmt::format("a file length of {} bytes", declared), "a multiple of 1024");
  }
  header_ = {declared, number(24), number(32)};
}

void PagedFile::Read(std::uint64_t offset, char* to, std::size_t n, std::string_view what) {
  if (offset > size() || n > size() - offset) {
    throw Error(std::min(offset, size()), fmt::format("the file ends within {} {}", n, what), "");
  }
  while (n > 0) {
    const std::uint64_t page = offset / kE57PayloadBytes;
    if (page != page_index_) LoadPage(page);
    const auto begin = static_cast<std::size_t>(offset % kE57PayloadBytes);
    const std::size_t step = std::min<std::size_t>(n, kE57PayloadBytes - begin);
    std::copy_n(page_.data() + begin, step, to);
    to += step;
    n -= step;
    offset += step;
  }
}

void PagedFile::LoadPage(std::uint64_t page) {
  page_index_ = UINT64_MAX;
  const std::uint64_t start = page * kE57PageBytes;
  source_.Seek(start);
  source_.Read(page_.data(), page_.size(), "bytes of a page");
  const std::uint32_t computed = Crc32c({page_.data(), kE57PayloadBytes});
  const auto stored = LoadBytes<std::uint32_t>(&page_[kE57PayloadBytes], std::endian::big);
  if (computed != stored) {
    throw source_.Error(start, fmt::format("page {} with checksum {:08x}", page, computed),
                        fmt::format("checksum {:08x}, as stored with the page", stored), kRemedy);
  }
  page_index_ = page;
}

std::uint64_t PagedFile::Logical(std::uint64_t physical, std::uint64_t stated_at,
                                 std::string_view what) const {
  if (physical >= header_.physical_bytes || physical % kE57PageBytes >= kE57PayloadBytes) {
    throw Error(stated_at, fmt::format("{} at byte {}", what, physical),
                fmt::format("a byte below {} that is no checksum", header_.physical_bytes));
  }
  return E57Logical(physical);
}

InputError PagedFile::Error(std::uint64_t offset, std::string found, std::string expected) const {
  return source_.Error(E57Physical(offset), std::move(found), std::move(expected), kRemedy);
}

}  // namespace backsight
