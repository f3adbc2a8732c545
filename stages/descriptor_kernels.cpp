#include "stages/descriptor_kernels.h"

#include <algorithm>
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

/// Less than half the squares, negative, of kRowBlock rows and two vectors of columns.
HWY_INLINE Block MinusSquares(const GridView& rows, std::size_t row, const GridView& columns,
                              std::size_t column) {
  const Tag d;
  const std::int32_t* half = rows.half_squares + row;
  const Ints a = hn::LoadU(d, columns.half_squares + column);
  const Ints b = hn::LoadU(d, columns.half_squares + column + hn::Lanes(d));
  const auto minus = [&](std::size_t r, Ints of_column) {
    return hn::Sub(hn::Set(d, -half[r]), of_column);
  };
  return {minus(0, a), minus(0, b), minus(1, a), minus(1, b),
          minus(2, a), minus(2, b), minus(3, a), minus(3, b)};
}

constexpr std::uint32_t kBothHalves = 0xFFFFFFFFU;
constexpr std::uint32_t kLowHalf = 0xFFFFU;  // without the rest

/// Adds the products of a pair of axes, or of those halves of it that the mask leaves.
template <std::uint32_t kMask>
HWY_INLINE void AddPair(const std::int32_t* HWY_RESTRICT row,
                        const std::int32_t* HWY_RESTRICT column, Block* sum) {
  const Tag d;
  const Ints a = hn::LoadU(d, column);
  const Ints b = hn::LoadU(d, column + hn::Lanes(d));
  const auto of_row = [&](std::size_t r) {
    return hn::Set(d, static_cast<std::int32_t>(static_cast<std::uint32_t>(row[r]) & kMask));
  };
  const Ints q0 = of_row(0);
  sum->a0 = AddProducts(sum->a0, q0, a);
  sum->b0 = AddProducts(sum->b0, q0, b);
  const Ints q1 = of_row(1);
  sum->a1 = AddProducts(sum->a1, q1, a);
  sum->b1 = AddProducts(sum->b1, q1, b);
  const Ints q2 = of_row(2);
  sum->a2 = AddProducts(sum->a2, q2, a);
  sum->b2 = AddProducts(sum->b2, q2, b);
  const Ints q3 = of_row(3);
  sum->a3 = AddProducts(sum->a3, q3, a);
  sum->b3 = AddProducts(sum->b3, q3, b);
}

template <std::size_t kBegin, std::size_t kEnd>
HWY_INLINE void AddPairs(const std::int32_t* HWY_RESTRICT row,
                         const std::int32_t* HWY_RESTRICT column, Block* sum) {
  HWY_UNROLL(16)  // GCC copies the sums from one turn of a loop to the next
  for (std::size_t pair = kBegin; pair < kEnd; ++pair) {
    AddPair<kBothHalves>(row + pair * kGridPadding, column + pair * kGridPadding, sum);
  }
}

HWY_INLINE Block Multiply(const GridView& rows, std::size_t row, const GridView& columns,
                          std::size_t column) {
  constexpr std::size_t kRestPair = kFirstPairs - 1;
  const std::int32_t* q = rows.pairs + PlaceOnGrid(0, row);
  const std::int32_t* p = columns.pairs + PlaceOnGrid(0, column);
  Block sum = MinusSquares(rows, row, columns, column);
  AddPairs<0, kRestPair>(q, p, &sum);
  AddPair<kLowHalf>(q + kRestPair * kGridPadding, p + kRestPair * kGridPadding, &sum);
  AddPairs<kFirstPairs, kDescriptorPairs>(q, p, &sum);
  return sum;
}

/// No less than Multiply() finds, by the first axes and the rest.
HWY_INLINE Block MultiplyFirst(const GridView& rows, std::size_t row, const GridView& columns,
                               std::size_t column) {
  Block sum = MinusSquares(rows, row, columns, column);
  AddPairs<0, kFirstPairs>(rows.pairs + PlaceOnGrid(0, row), columns.pairs + PlaceOnGrid(0, column),
                           &sum);
  return sum;
}

HWY_INLINE void KeepLargest(Ints value, std::int32_t* out) {
  const Tag d;
  hn::StoreU(hn::Max(value, hn::LoadU(d, out)), d, out);
}

/// The k-th largest of kSeedClasses values: no more than k - 1 are larger.
HWY_INLINE std::int32_t KthLargest(const std::int32_t* values, std::int32_t k) {
  const Tag d;
  Ints kth = hn::Set(d, std::numeric_limits<std::int32_t>::max());
  for (std::size_t i = 0; i < kSeedClasses; i += hn::Lanes(d)) {
    const Ints value = hn::LoadU(d, values + i);
    Ints minus_larger = hn::Zero(d);
    HWY_UNROLL(16)
    for (std::size_t n = 0; n < kSeedClasses; ++n) {
      const auto larger = hn::Gt(hn::Set(d, values[n]), value);
      minus_larger = hn::Add(minus_larger, hn::VecFromMask(d, larger));
    }
    const auto enough = hn::Gt(minus_larger, hn::Set(d, -k));
    kth = hn::IfThenElse(enough, hn::Min(kth, value), kth);
  }
  return hn::GetLane(hn::MinOfLanes(d, kth));
}

void Seeds(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
           std::size_t end, std::size_t k, std::int32_t* kth) {
  const std::size_t lanes = hn::Lanes(Tag());
  std::int32_t largest[kRowBlock * kSeedClasses];
  std::fill_n(largest, kRowBlock * kSeedClasses, std::numeric_limits<std::int32_t>::min());
  for (std::size_t j = begin; j < end; j += 2 * lanes) {
    const Block sum = Multiply(rows, row, columns, j);
    std::int32_t* a = largest + j % kSeedClasses;
    std::int32_t* b = largest + (j + lanes) % kSeedClasses;
    KeepLargest(sum.a0, a);
    KeepLargest(sum.b0, b);
    KeepLargest(sum.a1, a + kSeedClasses);
    KeepLargest(sum.b1, b + kSeedClasses);
    KeepLargest(sum.a2, a + 2 * kSeedClasses);
    KeepLargest(sum.b2, b + 2 * kSeedClasses);
    KeepLargest(sum.a3, a + 3 * kSeedClasses);
    KeepLargest(sum.b3, b + 3 * kSeedClasses);
  }
  for (std::size_t r = 0; r < kRowBlock; ++r) {
    kth[r] = KthLargest(largest + r * kSeedClasses, static_cast<std::int32_t>(k));
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
    const Block sum = MultiplyFirst(rows, row, columns, j);
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
                              Ints columns, std::size_t count, const GridPairs& found) {
  const Tag d;
  const hn::RebindToUnsigned<Tag> u;
  const auto close =
      hn::Gt(hn::Add(sum, hn::Max(hn::Set(d, row_limit), column_limits)), hn::Zero(d));
  hn::StoreU(hn::BitCast(u, hn::Compress(columns, close)), u, found.columns + count);
  hn::StoreU(hn::Set(u, static_cast<std::uint32_t>(row)), u, found.rows + count);
  return count + hn::CountTrue(d, close);
}

/// First columns of the blocks, two vectors of a panel each, that hold anything close as far as the
/// first axes tell; their number. A list and no branch, because nothing foretells which they are.
HWY_INLINE std::size_t Possible(const GridView& rows, std::size_t row, const GridView& columns,
                                const std::uint32_t* panels, std::size_t panel_count,
                                const GridLimits& limits, std::uint32_t* blocks) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t count = 0;
  for (std::size_t n = 0; n < panel_count; ++n) {
    const std::size_t begin = panels[n] * kGridPadding;
    for (std::size_t j = begin; j < begin + kGridPadding; j += 2 * lanes) {
      const Block sum = MultiplyFirst(rows, row, columns, j);
      const Ints of_a = hn::LoadU(d, limits.columns + j);
      const Ints of_b = hn::LoadU(d, limits.columns + j + lanes);
      blocks[count] = static_cast<std::uint32_t>(j);
      count += AnyPositive(Within(sum, limits.rows, of_a, of_b)) ? 1 : 0;
    }
  }
  return count;
}

HWY_INLINE std::size_t AppendClose(const GridView& rows, std::size_t row, const GridView& columns,
                                   std::size_t j, const GridLimits& limits, std::size_t count,
                                   const GridPairs& found) {
  const Tag d;
  const std::size_t lanes = hn::Lanes(d);
  const std::int32_t* limit = limits.rows;
  const Block sum = Multiply(rows, row, columns, j);
  const Ints of_a = hn::LoadU(d, limits.columns + j);
  const Ints of_b = hn::LoadU(d, limits.columns + j + lanes);
  if (!AnyPositive(Within(sum, limit, of_a, of_b))) return count;
  const Ints a = hn::Iota(d, static_cast<std::int32_t>(j));
  const Ints b = hn::Iota(d, static_cast<std::int32_t>(j + lanes));
  count = Append(sum.a0, limit[0], of_a, row, a, count, found);
  count = Append(sum.b0, limit[0], of_b, row, b, count, found);
  count = Append(sum.a1, limit[1], of_a, row + 1, a, count, found);
  count = Append(sum.b1, limit[1], of_b, row + 1, b, count, found);
  count = Append(sum.a2, limit[2], of_a, row + 2, a, count, found);
  count = Append(sum.b2, limit[2], of_b, row + 2, b, count, found);
  count = Append(sum.a3, limit[3], of_a, row + 3, a, count, found);
  return Append(sum.b3, limit[3], of_b, row + 3, b, count, found);
}

CloseCount Close(const GridView& rows, std::size_t row, const GridView& columns,
                 const std::uint32_t* panels, std::size_t panel_count, const GridLimits& limits,
                 bool first_axes, const GridPairs& found) {
  const std::size_t width = 2 * hn::Lanes(Tag());
  std::size_t count = 0;
  if (!first_axes) {
    for (std::size_t n = 0; n < panel_count; ++n) {
      for (std::size_t j = 0; j < kGridPadding; j += width) {
        const std::size_t column = panels[n] * kGridPadding + j;
        count = AppendClose(rows, row, columns, column, limits, count, found);
      }
    }
    return {count, panel_count * kGridPadding};
  }
  std::uint32_t blocks[kMostPanels * kGridPadding / 2 + 1];
  const std::size_t possible = Possible(rows, row, columns, panels, panel_count, limits, blocks);
  for (std::size_t n = 0; n < possible; ++n) {
    count = AppendClose(rows, row, columns, blocks[n], limits, count, found);
  }
  return {count, possible * width};
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Seeds);
HWY_EXPORT(ClosestColumns);
HWY_EXPORT(Close);

void FindSeeds(const GridView& rows, std::size_t row, const GridView& columns, std::size_t begin,
               std::size_t end, std::size_t k, std::span<std::int32_t, kRowBlock> kth) {
  HWY_DYNAMIC_DISPATCH(Seeds)(rows, row, columns, begin, end, k, kth.data());
}

void FindClosest(const GridView& rows, std::size_t row, const GridView& columns,
                 std::span<std::uint32_t, kRowBlock> out) {
  HWY_DYNAMIC_DISPATCH(ClosestColumns)(rows, row, columns, out.data());
}

CloseCount FindClose(const GridView& rows, std::size_t row, const GridView& columns,
                     std::span<const std::uint32_t> panels, const GridLimits& limits,
                     bool first_axes, const GridPairs& found) {
  return HWY_DYNAMIC_DISPATCH(Close)(rows, row, columns, panels.data(), panels.size(), limits,
                                     first_axes, found);
}

}  // namespace backsight
#endif
