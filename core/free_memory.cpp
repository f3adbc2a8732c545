#include "core/free_memory.h"

#include <malloc.h>

namespace backsight {

void ReturnLargeBlocksAtOnce() {
  constexpr int kMegabyte = 1 << 20;
  ::mallopt(M_MMAP_THRESHOLD, 2 * kMegabyte);
  ::mallopt(M_TRIM_THRESHOLD, 4 * kMegabyte);  // of small blocks; growing again takes time
}

void ReturnFreeMemory() { ::malloc_trim(0); }

}  // namespace backsight
