#include "tests/support/instruction_sets.h"

#include <hwy/targets.h>

namespace backsight {
void BindKernels(std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

void ForEachInstructionSet(const std::function<void(const std::string& name)>& body) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    BindKernels(target);
    body(hwy::TargetName(target));
  }
  BindKernels(0);
  body("best");  // may be one that few kernels are compiled for
}

}  // namespace backsight
