#pragma once

#include <cstddef>
#include <functional>

#include "core/execution.h"

namespace backsight {

/// ExecutionContext::ParallelFor where there is a context; without one everything happens in turn.
inline void ForEach(const ExecutionContext* context, std::size_t n,
                    const std::function<void(std::size_t)>& body, std::size_t grain = 1) {
  if (context != nullptr) {
    context->ParallelFor(n, body, grain);
  } else {
    for (std::size_t i = 0; i < n; ++i) body(i);
  }
}

}  // namespace backsight
