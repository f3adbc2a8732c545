#pragma once

#include <functional>
#include <string>

namespace backsight {

/// Calls `body(name)` once for every instruction set that the vectorised kernels are compiled for
/// and this machine has, the kernels bound to it.
void ForEachInstructionSet(const std::function<void(const std::string& name)>& body);

}  // namespace backsight
