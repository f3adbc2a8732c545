#pragma once

#include <hwy/targets.h>

namespace backsight {

/// Calls `body(name)` once for every instruction set that Highway's kernels are compiled for and
/// this machine has, the kernels bound to it.
template <class Body>
void ForEachInstructionSet(Body body) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    body(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace backsight
