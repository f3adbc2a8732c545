#include "stages/descriptor_kernels.h"

#include <limits>

// Sums of products of 16 bits in one instruction, where there is one.
#define HWY_WANT_AVX3_DL

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/descriptor_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Highway 1.0 leaves this one out, though it has chosen the target for it.
#if HWY_TARGET == HWY_AVX3_DL
HWY_PUSH_ATTRIBUTES(HWY_TARGET_STR ",avx512vnni")
#else
HWY_BEFORE_NAMESPACE();
#endif
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<std::int32_t, kSeedClasses>;
using Ints = hn::Vec<Tag>;

/// sum + the products of both halves of each lane.
HWY_INLINE Ints AddProducts(Ints sum, Ints a, Ints b) {
#if HWY_TARGET == HWY_AVX3_DL
  return Ints{_mm512_dpwssd_epi32(sum.raw, a.raw, b.raw)};
#elif HWY_TARGET == HWY_SCALAR || !HWY_ARCH_X86
  // One lane cannot be seen as two halves, and other processors spread the products over two sums.
  const auto low = [](Ints v) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(v)); };
  const auto high = [](Ints v) { return hn::ShiftRight<16>(v); };
  return hn::Add(sum, hn::Add(hn::Mul(low(a), low(b)), hn::Mul(high(a), high(b))));
#else
  const hn::Repartition<std::int16_t, Tag> half;
  Ints unused = hn::Zero(Tag());
  return hn::ReorderWidenMulAccumulate(Tag(), hn::BitCast(half, a), hn::BitCast(half, b), sum,
                                       unused);
#endif
}

/// Less than half the squared distances, and no less than that and one more, negative: of kRowBlock
/// rows and two vectors of columns.
struct Block {
  Ints a0, b0, a1, b1, a2, b2, a3, b3;
};

HWY_INLINE Block Multiply(const GridView& rows, std::size_t row, const GridView& columns,
                          std::size_t column) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  const std::int32_t* HWY_RESTRICT p = columns.pairs + column;
  const std::int32_t* HWY_RESTRICT q = rows.pairs + row;
  const std::int32_t* half = rows.half_squares + row;
  const Ints start_a = hn::LoadU(d, columns.half_squares + column);
  const Ints start_b = hn::LoadU(d, columns.half_squares + column + lanes);
  const auto start = [&](std::size_t r, Ints of_column) {
    return hn::Sub(hn::Set(d, -half[r]), of_column);
  };
  Block sum{start(0, start_a), start(0, start_b), start(1, start_a), start(1, start_b),
            start(2, start_a), start(2, start_b), start(3, start_a), start(3, start_b)};
  HWY_UNROLL(15)  // kDescriptorPairs: GCC copies the sums from one turn of a loop to the next
  for (std::size_t pair = 0; pair < kDescriptorPairs; ++pair) {
    const Ints a = hn::LoadU(d, p);
    const Ints b = hn::LoadU(d, p + lanes);
    const Ints q0 = hn::Set(d, q[0]);
    sum.a0 = AddProducts(sum.a0, q0, a);
    sum.b0 = AddProducts(sum.b0, q0, b);
    const Ints q1 = hn::Set(d, q[1]);
    sum.a1 = AddProducts(sum.a1, q1, a);
    sum.b1 = AddProducts(sum.b1, q1, b);
    const Ints q2 = hn::Set(d, q[2]);
    sum.a2 = AddProducts(sum.a2, q2, a);
    sum.b2 = AddProducts(sum.b2, q2, b);
    const Ints q3 = hn::Set(d, q[3]);
    sum.a3 = AddProducts(sum.a3, q3, a);
    sum.b3 = AddProducts(sum.b3, q3, b);
    p += columns.stride;
    q += rows.stride;
  }
  return sum;
}

HWY_INLINE void KeepLargest(Ints value, std::int32_t* out) {
  const Tag d;
  hn::StoreU(hn::Max(value, hn::LoadU(d, out)), d, out);
}

void Seeds(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
           std::size_t end, std::int32_t* out) {
  const std::size_t lanes = hn::Lanes(Tag());
  for (std::size_t j = begin; j < end; j += 2 * lanes) {
    const Block sum = Multiply(rows, row, columns, j);
    std::int32_t* a = out + j % kSeedClasses;
    std::int32_t* b = out + (j + lanes) % kSeedClasses;
    KeepLargest(sum.a0, a);
    KeepLargest(sum.b0, b);
    KeepLargest(sum.a1, a + kSeedClasses);
    KeepLargest(sum.b1, b + kSeedClasses);
    KeepLargest(sum.a2, a + 2 * kSeedClasses);
    KeepLargest(sum.b2, b + 2 * kSeedClasses);
    KeepLargest(sum.a3, a + 3 * kSeedClasses);
    KeepLargest(sum.b3, b + 3 * kSeedClasses);
  }
}

/// The closest column of each lane.
struct Closest {
  Ints value, column;

  HWY_INLINE void Offer(Ints offered, Ints its_column) {
    const auto closer = hn::Gt(offered, value);
    value = hn::Max(value, offered);
    column = hn::IfThenElse(closer, its_column, column);
  }
  HWY_INLINE std::uint32_t OfAll() const {
    HWY_ALIGN std::int32_t values[kSeedClasses];
    HWY_ALIGN std::int32_t numbers[kSeedClasses];
    hn::Store(value, Tag(), values);
    hn::Store(column, Tag(), numbers);
    std::size_t best = 0;
    for (std::size_t i = 1; i < hn::Lanes(Tag()); ++i) {
      const bool tied = values[i] == values[best] && numbers[i] < numbers[best];
      if (values[i] > values[best] || tied) best = i;
    }
    return static_cast<std::uint32_t>(numbers[best]);
  }
};

void ClosestColumns(const GridView& rows, std::size_t row, const GridView& columns,
                    std::uint32_t* out) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  const Closest none{hn::Set(d, std::numeric_limits<std::int32_t>::min()), hn::Zero(d)};
  Closest r0 = none, r1 = none, r2 = none, r3 = none;
  for (std::size_t j = 0; j < columns.size; j += 2 * lanes) {
    const Block sum = Multiply(rows, row, columns, j);
    const Ints a = hn::Iota(d, static_cast<std::int32_t>(j));
    const Ints b = hn::Iota(d, static_cast<std::int32_t>(j + lanes));
    r0.Offer(sum.a0, a), r0.Offer(sum.b0, b);
    r1.Offer(sum.a1, a), r1.Offer(sum.b1, b);
    r2.Offer(sum.a2, a), r2.Offer(sum.b2, b);
    r3.Offer(sum.a3, a), r3.Offer(sum.b3, b);
  }
  out[0] = r0.OfAll(), out[1] = r1.OfAll(), out[2] = r2.OfAll(), out[3] = r3.OfAll();
}

/// How far the closest pair of each lane is within its row's limit or its column's; negative where
/// none is.
HWY_INLINE Ints Within(const Block& sum, const std::int32_t* row_limits, Ints of_a, Ints of_b) {
  const Tag d;
  const auto of_row = [&](std::size_t r, Ints a, Ints b) {
    return hn::Add(hn::Max(a, b), hn::Set(d, row_limits[r]));
  };
  const Ints rows = hn::Max(hn::Max(of_row(0, sum.a0, sum.b0), of_row(1, sum.a1, sum.b1)),
                            hn::Max(of_row(2, sum.a2, sum.b2), of_row(3, sum.a3, sum.b3)));
  const Ints a = hn::Add(hn::Max(hn::Max(sum.a0, sum.a1), hn::Max(sum.a2, sum.a3)), of_a);
  const Ints b = hn::Add(hn::Max(hn::Max(sum.b0, sum.b1), hn::Max(sum.b2, sum.b3)), of_b);
  return hn::Max(rows, hn::Max(a, b));
}

HWY_INLINE bool AnyPositive(Ints v) {
  const Tag d;
  return !hn::AllFalse(d, hn::Gt(v, hn::Zero(d)));
}

HWY_INLINE std::size_t Append(Ints sum, std::int32_t row_limit, Ints column_limits, std::size_t row,
                              std::size_t column, std::size_t count, GridPair* found) {
  const Tag d;
  const auto close =
      hn::Gt(hn::Add(sum, hn::Max(hn::Set(d, row_limit), column_limits)), hn::Zero(d));
  if (hn::AllFalse(d, close)) return count;
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, close, bytes);
  for (auto bits = static_cast<std::uint32_t>(bytes[0] | bytes[1] << 8); bits != 0;
       bits &= bits - 1) {
    found[count++] = {static_cast<std::uint32_t>(row),
                      static_cast<std::uint32_t>(column) +
                          static_cast<std::uint32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero32(bits))};
  }
  return count;
}

std::size_t Close(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
                  std::size_t end, const GridLimits& limits, GridPair* found) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  const std::int32_t* limit = limits.rows;
  std::size_t count = 0;
  for (std::size_t j = begin; j < end; j += 2 * lanes) {
    const Block sum = Multiply(rows, row, columns, j);
    const Ints of_a = hn::LoadU(d, limits.columns + j);
    const Ints of_b = hn::LoadU(d, limits.columns + j + lanes);
    if (!AnyPositive(Within(sum, limit, of_a, of_b))) continue;
    count = Append(sum.a0, limit[0], of_a, row, j, count, found);
    count = Append(sum.b0, limit[0], of_b, row, j + lanes, count, found);
    count = Append(sum.a1, limit[1], of_a, row + 1, j, count, found);
    count = Append(sum.b1, limit[1], of_b, row + 1, j + lanes, count, found);
    count = Append(sum.a2, limit[2], of_a, row + 2, j, count, found);
    count = Append(sum.b2, limit[2], of_b, row + 2, j + lanes, count, found);
    count = Append(sum.a3, limit[3], of_a, row + 3, j, count, found);
    count = Append(sum.b3, limit[3], of_b, row + 3, j + lanes, count, found);
  }
  return count;
}

void Distances(const float* HWY_RESTRICT rows, const float* HWY_RESTRICT columns,
               const GridPair* found, std::size_t count, double* HWY_RESTRICT squared) {
  constexpr std::size_t kLanes = 8;
  constexpr std::size_t kWhole = kDescriptorBins / kLanes * kLanes;
  const hn::CappedTag<double, kLanes> d;
  const hn::Rebind<float, decltype(d)> in_float;
  const auto load = [&](const float* p) { return hn::PromoteTo(d, hn::LoadU(in_float, p)); };
  for (std::size_t n = 0; n < count; ++n) {
    const float* a = rows + found[n].row * kDescriptorBins;
    const float* b = columns + found[n].column * kDescriptorBins;
    HWY_ALIGN double sums[kLanes];
    for (std::size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
      auto sum = hn::Zero(d);
      for (std::size_t bin = lane; bin < kWhole; bin += kLanes) {
        const auto difference = hn::Sub(load(a + bin), load(b + bin));
        sum = hn::Add(sum, hn::Mul(difference, difference));
      }
      hn::Store(sum, d, sums + lane);
    }
    for (std::size_t bin = kWhole; bin < kDescriptorBins; ++bin) {
      const double difference = static_cast<double>(a[bin]) - static_cast<double>(b[bin]);
      sums[bin - kWhole] += difference * difference;
    }
    squared[n] =
        ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace backsight {

HWY_EXPORT(Seeds);
HWY_EXPORT(ClosestColumns);
HWY_EXPORT(Close);
HWY_EXPORT(Distances);

void FindSeeds(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
               std::size_t end, std::span<std::int32_t> out) {
  std::fill(out.begin(), out.end(), std::numeric_limits<std::int32_t>::min());
  HWY_DYNAMIC_DISPATCH(Seeds)(rows, row, columns, begin, end, out.data());
}

void FindClosest(const GridView& rows, std::size_t row, const GridView& columns,
                 std::span<std::uint32_t, kRowBlock> out) {
  HWY_DYNAMIC_DISPATCH(ClosestColumns)(rows, row, columns, out.data());
}

std::size_t FindClose(const GridView& rows, std::size_t row, const GridView& columns,
                      std::size_t begin, std::size_t end, const GridLimits& limits,
                      GridPair* found) {
  return HWY_DYNAMIC_DISPATCH(Close)(rows, row, columns, begin, end, limits, found);
}

void ComputeSquaredDistances(const float* rows, const float* columns,
                             std::span<const GridPair> pairs, double* squared) {
  HWY_DYNAMIC_DISPATCH(Distances)(rows, columns, pairs.data(), pairs.size(), squared);
}

}  // namespace backsight
#endif
