#pragma once

#include <algorithm>
#include <cstddef>

namespace backsight {

/// At most `most` of the indices below `size`, all of them if they are no more, evenly spread,
/// ascending.
class EvenChoice {
 public:
  EvenChoice(std::size_t size, std::size_t most) : size_(size), count_(std::min(size, most)) {}

  std::size_t count() const { return count_; }
  /// The i-th of those chosen, i < count().
  std::size_t operator[](std::size_t i) const { return i * size_ / count_; }

 private:
  std::size_t size_;
  std::size_t count_;
};

}  // namespace backsight
