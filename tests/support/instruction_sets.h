#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace backsight {

/// Binds the vectorised kernels to one of hwy::SupportedAndGeneratedTargets(), or with 0 to the
/// best that this machine has.
void BindKernels(std::int64_t target);

/// Calls `body(name)` once for every instruction set that the vectorised kernels are compiled for
/// and this machine has, the kernels bound to it.
void ForEachInstructionSet(const std::function<void(const std::string& name)>& body);

}  // namespace backsight
