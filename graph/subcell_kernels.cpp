#include "graph/subcell_kernels.h"

#include <algorithm>

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/subcell_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kMostLanes = 8;
using Tag = hn::CappedTag<double, kMostLanes>;
using Doubles = hn::Vec<Tag>;
using Ints = hn::Vec<hn::Rebind<std::int64_t, Tag>>;

/// `count` is a multiple of the lanes.
void Subcells(const double* points, std::size_t count, const KernelMotion& motion, double edge_m,
              std::uint64_t* HWY_RESTRICT keys) {
  const Tag d;
  const hn::Rebind<std::int64_t, Tag> in_ints;
  const hn::Rebind<std::uint64_t, Tag> in_keys;
  const Doubles per_metre = hn::Set(d, 1.0 / edge_m);
  const Ints half_range = hn::Set(in_ints, std::int64_t{1} << 20);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    Doubles x, y, z;
    hn::LoadInterleaved3(d, points + 3 * i, x, y, z);
    const auto cell = [&](std::size_t axis) {
      const double* row = motion.rotation.data() + 3 * axis;
      const Doubles turned =
          hn::Add(hn::Add(hn::Mul(x, hn::Set(d, row[0])), hn::Mul(y, hn::Set(d, row[1]))),
                  hn::Mul(z, hn::Set(d, row[2])));
      const Doubles moved = hn::Add(turned, hn::Set(d, motion.translation[axis]));
      return hn::Add(hn::ConvertTo(in_ints, hn::Floor(hn::Mul(moved, per_metre))), half_range);
    };
    const Ints key =
        hn::Or(hn::Or(hn::ShiftLeft<42>(cell(0)), hn::ShiftLeft<21>(cell(1))), cell(2));
    hn::StoreU(hn::BitCast(in_keys, key), in_keys, keys + i);
  }
}

void AllSubcells(const double* points, std::size_t count, const KernelMotion& motion, double edge_m,
                 std::uint64_t* HWY_RESTRICT keys) {
  const std::size_t whole = count - count % hn::Lanes(Tag());
  Subcells(points, whole, motion, edge_m, keys);
  double last[3 * kMostLanes] = {};
  std::uint64_t last_keys[kMostLanes];
  std::copy(points + 3 * whole, points + 3 * count, last);
  Subcells(last, hn::Lanes(Tag()), motion, edge_m, last_keys);
  std::copy_n(last_keys, count - whole, keys + whole);
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(AllSubcells);

void FindSubcells(const double* points, std::size_t count, const KernelMotion& motion,
                  double edge_m, std::uint64_t* keys) {
  HWY_DYNAMIC_DISPATCH(AllSubcells)(points, count, motion, edge_m, keys);
}

}  // namespace backsight
#endif
