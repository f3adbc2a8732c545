#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace backsight {

/// The words of a text as a POSIX shell would divide it: by blanks, where quotes and backslashes
/// keep them together. Nothing is expanded. Throws InputError that names `where` if a quote is left
/// open.
std::vector<std::string> SplitWords(std::string_view text, const std::string& where);

}  // namespace backsight
