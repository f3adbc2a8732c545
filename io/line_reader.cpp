#include "io/line_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace backsight {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

}  // namespace

bool LineReader::Next(std::string_view& line) {
  const bool at_start = source_.position() == 0;
  std::string_view ahead = source_.Peek(1);
  if (ahead.empty()) return false;
  std::size_t end = ahead.find('\n');
  if (end == std::string_view::npos && ahead.size() <= kMaxLineBytes) {
    ahead = source_.Peek(kMaxLineBytes + 1);
    end = ahead.find('\n');
  }
  ++line_number_;
  if (std::min(end, ahead.size()) > kMaxLineBytes) {
    throw TooLong();
  }
  const bool has_end = end != std::string_view::npos;
  line = has_end ? ahead.substr(0, end) : ahead;
  source_.Consume(line.size() + (has_end ? 1 : 0));
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (at_start && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  return true;
}

std::string_view LineReader::Require(std::string_view expected) {
  std::string_view line;
  if (!Next(line)) {
    ++line_number_;
    throw Error("the file ends here", std::string(expected),
                "the file is cut short: copy or export it again");
  }
  return line;
}

InputError LineReader::TooLong() const {
  return Error(fmt::format("a line longer than {} bytes", kMaxLineBytes), "lines of text",
               "the file is damaged or not a text file");
}

std::size_t LineReader::WholeLines(std::string_view ahead, std::size_t n,
                                   std::size_t* lines) const {
  std::size_t at = 0;
  for (*lines = 0; *lines < n; ++*lines) {
    const std::size_t end = ahead.find('\n', at);
    if (end == std::string_view::npos || end - at > kMaxLineBytes) break;
    at = end + 1;
  }
  return at;
}

std::size_t LineReader::Take(std::size_t n, std::string& text) {
  text.clear();
  const bool at_start = source_.position() == 0;
  std::size_t taken = 0;
  std::size_t want = 1;
  while (taken < n && text.size() < kBlockBytes) {
    const std::string_view ahead = source_.Peek(want);
    if (ahead.empty()) break;
    std::size_t lines = 0;
    std::size_t bytes = WholeLines(ahead, n - taken, &lines);
    const bool has_end = bytes > 0;
    if (!has_end && want == 1) {  // the line may end beyond what is buffered
      want = kMaxLineBytes + 1;
      continue;
    }
    if (!has_end && ahead.size() > kMaxLineBytes) {
      if (taken > 0) break;
      ++line_number_;
      throw TooLong();
    }
    if (!has_end) bytes = ahead.size(), lines = 1;  // the last line of the file
    text.append(ahead.substr(0, bytes));
    if (!has_end) text += '\n';
    source_.Consume(bytes);
    taken += lines;
    line_number_ += lines;
    want = 1;
  }
  if (at_start && text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  return taken;
}

std::uint64_t LineReader::Skip(std::uint64_t n, const std::function<void()>& between) {
  std::uint64_t skipped = 0;
  bool open_line = false;
  while (skipped < n) {
    if (between) between();
    const std::string_view ahead = source_.Peek(1);
    if (ahead.empty()) {
      if (open_line) ++skipped;
      break;
    }
    const char* at = ahead.data();
    const char* const end = at + ahead.size();
    while (skipped < n && at != end) {
      const void* found = std::memchr(at, '\n', static_cast<std::size_t>(end - at));
      open_line = found == nullptr;
      at = open_line ? end : static_cast<const char*>(found) + 1;
      if (!open_line) ++skipped;
    }
    source_.Consume(static_cast<std::size_t>(at - ahead.data()));
  }
  line_number_ += skipped;
  return skipped;
}

void LineReader::Restart(std::uint64_t position, std::uint64_t line_number) {
  source_.Seek(position);
  line_number_ = line_number;
}

InputError LineReader::Error(std::string found, std::string expected, std::string remedy) const {
  return ErrorInLine(source_.path(), line_number_, std::move(found), std::move(expected),
                     std::move(remedy));
}

InputError ErrorInLine(const std::string& path, std::uint64_t line, std::string found,
                       std::string expected, std::string remedy) {
  return InputError(
      {fmt::format("{}:{}", path, line), std::move(found), std::move(expected), std::move(remedy)});
}

}  // namespace backsight
