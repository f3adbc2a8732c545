#include "io/text_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/error.h"

namespace backsight {

std::string ReadTextFile(const std::string& path, std::uintmax_t max_bytes) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw InputError({path, "no such file", "", ""});
  if (!std::filesystem::is_regular_file(status)) throw InputError({path, "not a file", "", ""});
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > max_bytes) {
    throw InputError({path, fmt::format("{} bytes", size),
                      fmt::format("a text file of at most {} bytes", max_bytes), ""});
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream.is_open() || stream.bad()) {
    throw InputError({path, "cannot be read", "", "check its permissions"});
  }
  return text;
}

}  // namespace backsight
