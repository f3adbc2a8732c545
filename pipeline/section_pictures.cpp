#include "pipeline/section_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace backsight {
namespace {

struct Span {
  Eigen::Vector2d min, max;
};

/// What the section holds, without the last percents on all sides.
std::optional<Span> SpanOf(const PlacedClouds& clouds, const Section& section,
                           const ExecutionContext& context) {
  std::vector<double> u, v;
  ForEachCut(clouds, section, context, [&](const VoxelCut& cut, std::size_t) {
    u.push_back(cut.middle.x());
    v.push_back(cut.middle.y());
  });
  if (u.empty()) return std::nullopt;
  const auto [left, right] = MiddleOf(std::move(u));
  const auto [low, high] = MiddleOf(std::move(v));
  return Span{{left, low}, {right, high}};
}

std::string Title(const NamedSection& named, const PlacedClouds& clouds) {
  return named.upright
             ? fmt::format("Vertical section {0}\xe2\x80\x93{0}\xe2\x80\xb2", named.name)
             : fmt::format("Horizontal section at {} = {:.2f} m", clouds.height, named.at_m);
}

void NameAxes(const NamedSection& named, const PlacedClouds& clouds, PictureRecord* picture) {
  picture->across = named.upright ? fmt::format("along {0}\xe2\x80\x93{0}\xe2\x80\xb2", named.name)
                                  : clouds.across;
  picture->up = named.upright ? clouds.height : clouds.up;
}

PictureRecord DrawWhole(const PlacedClouds& clouds, const NamedSection& named, const Span& span,
                        const ExecutionContext& context) {
  constexpr int kWidth = 1000;
  constexpr int kMaxHeight = 900;
  PictureRecord picture = DrawSection(clouds, named.section,
                                      PictureWindow::Around(span.min, span.max, kWidth, kMaxHeight),
                                      PictureRecord::Kind::kSection, context);
  picture.title = Title(named, clouds);
  picture.caption = fmt::format(
      "{:.0f} mm thick, {}; one pixel is {:.0f} mm. Each voxel is cut where it stands: as a line a "
      "voxel long and as thick as two standard deviations of its points, but at least a pixel and "
      "a half. Where stations coincide, their colours alternate.",
      1000.0 * kThicknessM, clouds.origin, 1000.0 * picture.metres_per_pixel);
  NameAxes(named, clouds, &picture);
  return picture;
}

PictureRecord DrawDetail(const PlacedClouds& clouds, const NamedSection& named,
                         const ExecutionContext& context) {
  constexpr int kWidth = 1000;
  PictureWindow window;
  window.metres_per_pixel = kDetailM / kWidth;
  window.left_top = *named.detail + 0.5 * Eigen::Vector2d(-kDetailM, kDetailHighM);
  window.width_px = kWidth;
  window.height_px = static_cast<int>(std::lround(kWidth * kDetailHighM / kDetailM));
  PictureRecord picture =
      DrawSection(clouds, named.section, window, PictureRecord::Kind::kDetail, context);
  picture.title =
      (named.apart_m ? "Where surfaces lie furthest apart: " : "Detail: ") + Title(named, clouds);
  const std::string place =
      named.apart_m
          ? fmt::format(
                "around the half metre whose compared surfaces lie furthest apart, {:.1f} mm "
                "in the median",
                1000.0 * *named.apart_m)
          : "where most surface was measured by several stations";
  picture.caption = fmt::format(
      "{:g} m wide, {}; one pixel is {:.0f} mm. A wall that appears twice in different colours is "
      "a misalignment; a lone thing that does has moved between the scans: a door, a vehicle.",
      kDetailM, place, 1000.0 * window.metres_per_pixel);
  NameAxes(named, clouds, &picture);
  return picture;
}

/// The section as a whole, if wanted, and its detail; nothing where it cuts nothing.
std::vector<PictureRecord> DrawSection(const PlacedClouds& clouds, const NamedSection& named,
                                       const ExecutionContext& context) {
  std::vector<PictureRecord> pictures;
  if (!named.apart_m) {
    const std::optional<Span> span = SpanOf(clouds, named.section, context);
    if (!span) return pictures;
    pictures.push_back(DrawWhole(clouds, named, *span, context));
  }
  if (named.detail) pictures.push_back(DrawDetail(clouds, named, context));
  return pictures;
}

}  // namespace

std::vector<PictureRecord> DrawSections(const PlacedClouds& clouds,
                                        const std::vector<NamedSection>& sections,
                                        const ExecutionContext& context) {
  std::vector<std::vector<PictureRecord>> drawn(sections.size());
  context.ParallelFor(drawn.size(),
                      [&](std::size_t i) { drawn[i] = DrawSection(clouds, sections[i], context); });
  std::vector<PictureRecord> pictures;
  for (std::vector<PictureRecord>& own : drawn) {
    std::move(own.begin(), own.end(), std::back_inserter(pictures));
  }
  return pictures;
}

}  // namespace backsight
