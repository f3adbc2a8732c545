#include "stages/descriptor_distances.h"

#include <algorithm>
#include <limits>
#include <vector>

// Highway compiles this file once for every instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stages/descriptor_distances.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace backsight {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kStep = 16;   // columns that are looked at together
constexpr std::size_t kRows = 4;    // rows whose products are formed together
constexpr std::size_t kTile = 256;  // columns whose bins stay in the first cache
using Tag = hn::CappedTag<float, kStep>;

/// Puts a neighbour in its place among the k nearest; equal distances stay in the order of coming.
HWY_INLINE void Offer(float squared, std::size_t index, std::size_t k, DescriptorNeighbor* list) {
  if (!(squared < list[k - 1].squared)) return;
  std::size_t place = k - 1;
  for (; place > 0 && squared < list[place - 1].squared; --place) list[place] = list[place - 1];
  list[place] = {squared, static_cast<std::uint32_t>(index)};
}

/// What a search keeps: lists of both sides and every column's k-th distance once more, in vectors.
struct Lists {
  std::size_t k;
  DescriptorNeighbor* of_rows;
  DescriptorNeighbor* of_columns;
  float* column_limits;
};

/// Products of kRows rows with kStep columns.
HWY_INLINE void Multiply(const DescriptorRows& a, std::size_t row, const DescriptorColumns& b,
                         std::size_t column, float* HWY_RESTRICT products) {
  const Tag d;
  const float* q = a.bins + row * kDescriptorBins;
  for (std::size_t i = 0; i < kStep; i += hn::Lanes(d)) {
    auto sum0 = hn::Zero(d);
    auto sum1 = hn::Zero(d);
    auto sum2 = hn::Zero(d);
    auto sum3 = hn::Zero(d);
    const float* p = b.bins + column + i;
    for (std::size_t bin = 0; bin < kDescriptorBins; ++bin) {
      const auto of_columns = hn::LoadU(d, p + bin * b.stride);
      sum0 = hn::Add(sum0, hn::Mul(hn::Set(d, q[bin]), of_columns));
      sum1 = hn::Add(sum1, hn::Mul(hn::Set(d, q[kDescriptorBins + bin]), of_columns));
      sum2 = hn::Add(sum2, hn::Mul(hn::Set(d, q[2 * kDescriptorBins + bin]), of_columns));
      sum3 = hn::Add(sum3, hn::Mul(hn::Set(d, q[3 * kDescriptorBins + bin]), of_columns));
    }
    hn::Store(sum0, d, products + i);
    hn::Store(sum1, d, products + kStep + i);
    hn::Store(sum2, d, products + 2 * kStep + i);
    hn::Store(sum3, d, products + 3 * kStep + i);
  }
}

/// Turns a row's products into squared distances; true if any may enter a list.
HWY_INLINE bool Compare(float square, const float* HWY_RESTRICT column_squares,
                        const float* HWY_RESTRICT column_limits, float row_limit,
                        float* HWY_RESTRICT products) {
  const Tag d;
  bool any = false;
  for (std::size_t i = 0; i < kStep; i += hn::Lanes(d)) {
    const auto squares = hn::Add(hn::Set(d, square), hn::LoadU(d, column_squares + i));
    const auto twice = hn::Mul(hn::Set(d, 2.0F), hn::Load(d, products + i));
    const auto squared = hn::Sub(squares, twice);
    hn::Store(squared, d, products + i);
    const auto limit = hn::Max(hn::Set(d, row_limit), hn::LoadU(d, column_limits + i));
    any |= !hn::AllFalse(d, hn::Lt(squared, limit));
  }
  return any;
}

void SearchTile(const DescriptorRows& a, const DescriptorColumns& b, std::size_t begin,
                std::size_t end, const Lists& lists) {
  HWY_ALIGN float products[kRows * kStep];
  for (std::size_t row = 0; row < a.rows; row += kRows) {
    for (std::size_t column = begin; column < end; column += kStep) {
      Multiply(a, row, b, column, products);
      for (std::size_t r = 0; r < kRows && row + r < a.rows; ++r) {
        float* squared = products + r * kStep;
        DescriptorNeighbor* of_row = lists.of_rows + (row + r) * lists.k;
        if (!Compare(a.squares[row + r], b.squares + column, lists.column_limits + column,
                     of_row[lists.k - 1].squared, squared)) {
          continue;
        }
        for (std::size_t i = 0; i < kStep && column + i < b.columns; ++i) {
          DescriptorNeighbor* of_column = lists.of_columns + (column + i) * lists.k;
          Offer(squared[i], column + i, lists.k, of_row);
          Offer(squared[i], row + r, lists.k, of_column);
          lists.column_limits[column + i] = of_column[lists.k - 1].squared;
        }
      }
    }
  }
}

void Search(const DescriptorRows& a, const DescriptorColumns& b, std::size_t k,
            DescriptorNeighbor* of_rows, DescriptorNeighbor* of_columns, float* column_limits) {
  const Lists lists{k, of_rows, of_columns, column_limits};
  for (std::size_t begin = 0; begin < b.columns; begin += kTile) {
    SearchTile(a, b, begin, begin + kTile < b.columns ? begin + kTile : b.columns, lists);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace backsight
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace backsight {

HWY_EXPORT(Search);

void FindNearestDescriptors(const DescriptorRows& rows, const DescriptorColumns& columns,
                            std::size_t k, std::span<DescriptorNeighbor> of_rows,
                            std::span<DescriptorNeighbor> of_columns) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::fill(of_rows.begin(), of_rows.end(), DescriptorNeighbor{kInfinity, 0});
  std::fill(of_columns.begin(), of_columns.end(), DescriptorNeighbor{kInfinity, 0});
  // Columns that only fill the last vector let nothing in.
  std::vector<float> limits(columns.stride, -kInfinity);
  std::fill_n(limits.begin(), columns.columns, kInfinity);
  HWY_DYNAMIC_DISPATCH(Search)(rows, columns, k, of_rows.data(), of_columns.data(), limits.data());
}

}  // namespace backsight
#endif
