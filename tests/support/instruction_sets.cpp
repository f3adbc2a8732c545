#include "tests/support/instruction_sets.h"

#include <hwy/targets.h>

namespace backsight {
namespace {

void Bind(int64_t targets) {
  hwy::SetSupportedTargetsForTest(targets);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace

void ForEachInstructionSet(const std::function<void(const std::string& name)>& body) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    Bind(target);
    body(hwy::TargetName(target));
  }
  constexpr int64_t kAll = 0;
  Bind(kAll);
}

}  // namespace backsight
