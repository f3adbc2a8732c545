#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace backsight {

inline constexpr std::size_t kListLanes = 8;

/// A part of a list of nearest neighbours. Numbers are held as double, beside the distances they
/// move with.
struct alignas(64) NearestPart {
  std::array<double, kListLanes> squared;
  std::array<double, kListLanes> numbers;
};

/// Lists of the nearest that have been offered, ascending by squared distance, equal ones by
/// number.
class NearestLists {
 public:
  /// `count` lists that hold at least `k` each: nothing yet, at an infinite distance.
  NearestLists(std::size_t count, std::size_t k);

  /// Offers numbers[n] at squared[n] to list lists[n], each number to a list once. Time O(k) each.
  void Offer(std::span<const std::uint32_t> lists, std::span<const double> squared,
             std::span<const std::uint32_t> numbers);

  /// The n-th of a list, n < k.
  double Squared(std::size_t list, std::size_t n) const {
    return parts_[list * parts_per_list_ + n / kListLanes].squared[n % kListLanes];
  }
  std::uint32_t Number(std::size_t list, std::size_t n) const {
    const NearestPart& part = parts_[list * parts_per_list_ + n / kListLanes];
    return static_cast<std::uint32_t>(part.numbers[n % kListLanes]);
  }

 private:
  std::size_t parts_per_list_;
  std::vector<NearestPart> parts_;
};

}  // namespace backsight
