#pragma once

#include <string>

namespace backsight {

struct ExpandedPath {
  std::string path;
  std::string fault;  ///< empty, or what is wrong: "environment variable SCANS is not set"
};

/// Replaces every ${NAME} in `text` by that environment variable; an unset or empty variable is a
/// fault, because "${SCANS}/S1.ptx" must not quietly become "/S1.ptx". Other uses of $ stay.
ExpandedPath ExpandEnvironment(const std::string& text);

}  // namespace backsight
