#include "io/e57/paged_writer.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/error.h"
#include "io/e57/crc32c.h"
#include "io/endian_bytes.h"

namespace backsight {
namespace {

/// The whole page around its payload.
std::string PageOf(std::string_view payload) {
  std::string page(payload);
  page.resize(kE57PageBytes);
  StoreBytes(&page[kE57PayloadBytes], Crc32c(payload), std::endian::big);
  return page;
}

}  // namespace

void PagedWriter::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const std::size_t step = std::min<std::size_t>(bytes.size(), kE57PayloadBytes - page_.size());
    page_.append(bytes.substr(0, step));
    bytes.remove_prefix(step);
    if (page_.size() == kE57PayloadBytes) FinishPage();
  }
}

void PagedWriter::FinishPage() {
  page_.resize(kE57PayloadBytes, '\0');
  file_.Write(PageOf(page_));
  if (const auto kept = kept_.find(pages_); kept != kept_.end()) kept->second = page_;
  ++pages_;
  page_.clear();
}

void PagedWriter::Align() {
  constexpr std::string_view kZeros("\0\0\0", 3);
  Write(kZeros.substr(0, (4 - position() % 4) % 4));
}

std::uint64_t PagedWriter::Reserve(std::size_t n) {
  const std::uint64_t offset = position();
  for (std::uint64_t at = offset; at < offset + n; ++at) kept_.try_emplace(at / kE57PayloadBytes);
  Write(std::string(n, '\0'));
  return offset;
}

void PagedWriter::Fill(std::uint64_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const std::uint64_t number = offset / kE57PayloadBytes;
    const auto begin = static_cast<std::size_t>(offset % kE57PayloadBytes);
    const std::size_t step = std::min<std::size_t>(bytes.size(), kE57PayloadBytes - begin);
    const auto kept = kept_.find(number);
    BACKSIGHT_CHECK(kept != kept_.end(), "only reserved bytes can be filled in");
    std::string& page = number == pages_ ? page_ : kept->second;
    page.replace(begin, step, bytes.substr(0, step));
    if (number < pages_) file_.Overwrite(number * kE57PageBytes, PageOf(page));
    bytes.remove_prefix(step);
    offset += step;
  }
}

std::uint64_t PagedWriter::PhysicalBytes() const {
  return (pages_ + (page_.empty() ? 0 : 1)) * kE57PageBytes;
}

void PagedWriter::Seal() {
  if (!page_.empty()) FinishPage();
  file_.Seal();
}

void PagedWriter::Commit() {
  if (!page_.empty()) FinishPage();
  file_.Commit();
}

}  // namespace backsight
