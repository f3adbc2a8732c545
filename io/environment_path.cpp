#include "io/environment_path.h"

#include <cstdlib>

namespace backsight {
namespace {

bool IsVariableName(const std::string& name) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_";
  return !name.empty() && name.find_first_of(kLetters) == 0 &&
         name.find_first_not_of(std::string(kLetters) + "0123456789") == std::string::npos;
}

}  // namespace

ExpandedPath ExpandEnvironment(const std::string& text) {
  ExpandedPath result;
  std::size_t begin = 0;
  while (true) {
    const std::size_t open = text.find("${", begin);
    result.path += text.substr(begin, open - begin);
    if (open == std::string::npos) return result;
    const std::size_t close = text.find('}', open);
    if (close == std::string::npos) return {"", "'${' without its '}'"};
    const std::string name = text.substr(open + 2, close - open - 2);
    if (!IsVariableName(name)) return {"", "'${...}' must hold the name of a variable"};
    const char* value = std::getenv(name.c_str());
    if (value == nullptr || *value == '\0') {
      return {"",
              "environment variable " + name + (value == nullptr ? " is not set" : " is empty")};
    }
    result.path += value;
    begin = close + 1;
  }
}

}  // namespace backsight
