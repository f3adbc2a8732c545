#include "stages/nearest_lists.h"

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/nearest_lists.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, kListLanes>;
using Doubles = hn::Vec<Tag>;

/// Moves all that comes after what is offered one place up, without a branch: nothing foretells
/// where it belongs.
class Insertion {
 public:
  HWY_INLINE Insertion() {
    HWY_ALIGN constexpr std::int64_t kOneUp[kListLanes] = {0, 0, 1, 2, 3, 4, 5, 6};
    one_up_ = hn::SetTableIndices(Tag(), kOneUp);
  }

  HWY_INLINE void Into(NearestPart* list, std::size_t parts, double squared, double number) const {
    const Tag d;
    const Doubles s = hn::Set(d, squared);
    const Doubles n = hn::Set(d, number);
    for (std::size_t p = parts; p-- > 0;) {
      NearestPart& part = list[p];
      for (std::size_t at = kListLanes; at > 0;) {
        at -= hn::Lanes(d);
        const NearestPart* below = at > 0 ? &part : p > 0 ? &list[p - 1] : nullptr;
        const std::size_t last = (at + kListLanes - 1) % kListLanes;
        double* at_squared = part.squared.data() + at;
        double* at_number = part.numbers.data() + at;
        const Doubles own_s = hn::Load(d, at_squared);
        const Doubles own_n = hn::Load(d, at_number);
        const Doubles below_s = OneUp(own_s, below != nullptr ? below->squared[last] : kNearest);
        const Doubles below_n = OneUp(own_n, below != nullptr ? below->numbers[last] : 0.0);
        const auto stays = IsBefore(own_s, own_n, s, n);
        const auto here = IsBefore(below_s, below_n, s, n);
        const Doubles new_s = hn::IfThenElse(here, s, below_s);
        const Doubles new_n = hn::IfThenElse(here, n, below_n);
        hn::Store(hn::IfThenElse(stays, own_s, new_s), d, at_squared);
        hn::Store(hn::IfThenElse(stays, own_n, new_n), d, at_number);
      }
    }
  }

 private:
  static constexpr double kNearest = -std::numeric_limits<double>::infinity();

  HWY_INLINE Doubles OneUp(Doubles v, double first) const {
    const Tag d;
    return hn::IfThenElse(hn::FirstN(d, 1), hn::Set(d, first), hn::TableLookupLanes(v, one_up_));
  }
  static HWY_INLINE hn::Mask<Tag> IsBefore(Doubles s, Doubles n, Doubles other_s, Doubles other_n) {
    return hn::Or(hn::Lt(s, other_s), hn::And(hn::Eq(s, other_s), hn::Lt(n, other_n)));
  }

  decltype(hn::SetTableIndices(Tag(), static_cast<const std::int64_t*>(nullptr))) one_up_;
};

void Offers(NearestPart* parts, std::size_t parts_per_list, const std::uint32_t* lists,
            const double* squared, const std::uint32_t* numbers, std::size_t count) {
  const Insertion insertion;
  for (std::size_t n = 0; n < count; ++n) {
    insertion.Into(parts + lists[n] * parts_per_list, parts_per_list, squared[n],
                   static_cast<double>(numbers[n]));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Offers);

NearestLists::NearestLists(std::size_t count, std::size_t k)
    : parts_per_list_((k + kListLanes - 1) / kListLanes) {
  NearestPart nothing{};
  nothing.squared.fill(std::numeric_limits<double>::infinity());
  parts_.assign(count * parts_per_list_, nothing);
}

void NearestLists::Offer(std::span<const std::uint32_t> lists, std::span<const double> squared,
                         std::span<const std::uint32_t> numbers) {
  HWY_DYNAMIC_DISPATCH(Offers)
  (parts_.data(), parts_per_list_, lists.data(), squared.data(), numbers.data(), lists.size());
}

}  // namespace backsight
#endif
