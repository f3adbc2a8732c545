#include "io/report_distances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/html_table.h"
#include "io/html_text.h"

namespace backsight {
namespace {

constexpr double kWidth = 960.0;
constexpr double kHeight = 320.0;
constexpr double kLeft = 70.0;
constexpr double kRight = 20.0;
constexpr double kTop = 62.0;  // for the names of the quantiles
constexpr double kBottom = 44.0;

std::string Mm(double metres, int decimals = 2) {
  return FixedText(1000.0 * metres, decimals, "distances of surfaces");
}

class Histogram {
 public:
  explicit Histogram(const DistanceRecord& record)
      : record_(record), end_m_(record.bin_m * static_cast<double>(record.bins.size())) {
    most_ = std::max<std::uint64_t>(1, *std::max_element(record.bins.begin(), record.bins.end()));
  }

  std::string Svg() const {
    std::string svg = fmt::format(
        "<svg class=\"chart\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" "
        "aria-label=\"Histogram of distances between surfaces\">\n",
        kWidth, kHeight);
    for (std::size_t i = 0; i < record_.bins.size(); ++i) svg += Bar(i);
    svg += Axes();
    const DistanceFigures& total = record_.total;
    svg += Quantile(total.median_m, "median", 0) + Quantile(total.p68_m, "68 %", 1) +
           Quantile(total.p95_m, "95 %", 2);
    return svg + "</svg>\n";
  }

 private:
  double X(double metres) const { return kLeft + (kWidth - kLeft - kRight) * metres / end_m_; }
  double Y(double share) const { return kHeight - kBottom - (kHeight - kTop - kBottom) * share; }

  std::string Bar(std::size_t i) const {
    const double left = X(record_.bin_m * static_cast<double>(i));
    const double right = X(record_.bin_m * static_cast<double>(i + 1));
    const double y = Y(static_cast<double>(record_.bins[i]) / static_cast<double>(most_));
    return fmt::format(
        "<rect class=\"bar\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>\n",
        left, y, right - left, Y(0.0) - y);
  }

  std::string Axes() const {
    std::string svg = fmt::format("<path class=\"axis\" d=\"M{0:.1f} {1:.1f}V{2:.1f}H{3:.1f}\"/>\n",
                                  kLeft, kTop, Y(0.0), kWidth - kRight);
    for (std::size_t i = 0; i <= record_.bins.size(); i += 5) {
      const double metres = record_.bin_m * static_cast<double>(i);
      svg += fmt::format(
          "<path class=\"tick\" d=\"M{0:.1f} {1:.1f}v6\"/><text class=\"note\" x=\"{0:.1f}\" "
          "y=\"{2:.1f}\" text-anchor=\"middle\">{3:g}</text>\n",
          X(metres), Y(0.0), Y(0.0) + 20, 1000.0 * metres);
    }
    const double share =
        100.0 * static_cast<double>(most_) / static_cast<double>(record_.total.samples);
    return svg +
           fmt::format(
               "<text class=\"note\" x=\"{0:.1f}\" y=\"{1:.1f}\" text-anchor=\"end\">distance "
               "[mm]</text>\n<text class=\"note\" x=\"{2:.1f}\" y=\"{3:.1f}\" "
               "text-anchor=\"end\">{4:.1f} %</text><text class=\"note\" x=\"{2:.1f}\" "
               "y=\"{5:.1f}\" text-anchor=\"end\">0 %</text>\n",
               kWidth - kRight, kHeight - 6, kLeft - 8, kTop + 5, share, Y(0.0) + 4);
  }

  /// A line over the bars; names of neighbours stand on lines of their own.
  std::string Quantile(double metres, const char* name, int line) const {
    const double x = X(metres);
    if (metres > end_m_) return {};
    return fmt::format(
        "<path class=\"quantile\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text class=\"label\" "
        "x=\"{3:.1f}\" y=\"{4:.1f}\">{5} {6} mm</text>\n",
        x, 8.0 + 18.0 * line, Y(0.0), x + 5, 20.0 + 18.0 * line, name, Mm(metres));
  }

  const DistanceRecord& record_;
  double end_m_;
  std::uint64_t most_ = 1;
};

/// All pairs if they are few, otherwise those that are furthest apart.
std::string PairTable(const DistanceRecord& record) {
  constexpr std::size_t kMost = 30;
  std::vector<const PairDistanceRecord*> pairs;
  for (const PairDistanceRecord& pair : record.pairs) pairs.push_back(&pair);
  std::stable_sort(pairs.begin(), pairs.end(), [](const auto* a, const auto* b) {
    return a->figures.p95_m > b->figures.p95_m;
  });
  const bool cut = pairs.size() > kMost;
  if (cut) pairs.resize(kMost);
  HtmlTable table({{"stations"},
                   {"samples", true},
                   {"median [mm]", true},
                   {"68 % [mm]", true},
                   {"95 % [mm]", true}});
  for (const PairDistanceRecord* pair : pairs) {
    table.Row({HtmlBold(pair->stations[0]) + " \xe2\x80\x93 " + HtmlBold(pair->stations[1]),
               GroupedText(pair->figures.samples), Mm(pair->figures.median_m),
               Mm(pair->figures.p68_m), Mm(pair->figures.p95_m)});
  }
  return table.Finish() + (cut ? HtmlSentence(fmt::format(
                                     "The {} of {} pairs with the largest 95 %; report.json has "
                                     "all.",
                                     kMost, record.pairs.size()))
                               : "");
}

}  // namespace

std::string DistanceSection(const RunRecord& run) {
  if (!run.distances || run.distances->bins.empty() || run.distances->total.samples == 0) {
    return HtmlSentence("No two stations measured the same planar surfaces.");
  }
  const DistanceRecord& record = *run.distances;
  return HtmlSentence(fmt::format(
             "{} samples between {} pairs of stations: <b>median {} mm, 68 % within {} mm, 95 % "
             "within {} mm</b>; {} are beyond the chart.",
             GroupedText(record.total.samples), record.pairs.size(), Mm(record.total.median_m),
             Mm(record.total.p68_m), Mm(record.total.p95_m), GroupedText(record.beyond))) +
         Histogram(record).Svg() +
         HtmlSentence(fmt::format(
             "<span class=\"soft\">A distance is that of the mean of a patch (the points within "
             "two voxel edges of a voxel, where they lie on a plane) from the plane of the patch "
             "about the nearest voxel of another station, without sign, in the adjusted network. "
             "Both face the same way within 30 degrees; voxels more than {} mm apart are different "
             "surfaces and do not count. Both directions of a pair, evenly chosen.</span>",
             Mm(record.search_m, 0))) +
         PairTable(record);
}

}  // namespace backsight
