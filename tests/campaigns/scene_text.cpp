#include "tests/campaigns/scene_text.h"

#include <fmt/format.h>

#include <iterator>

namespace backsight {
namespace {

std::string Pair(const Eigen::Vector2d& v) { return fmt::format("[{:.4f}, {:.4f}]", v.x(), v.y()); }

std::string LineOf(const Kerb& k) {
  return fmt::format("from_m: {}, to_m: {}, width_m: {}, height_m: {}", Pair(k.from_m),
                     Pair(k.to_m), k.width_m, k.height_m);
}

std::string LineOf(const Building& b) {
  constexpr const char* kStyles[] = {"masonry", "modern", "industrial"};
  constexpr const char* kRoofs[] = {"flat", "gable", "hip"};
  return fmt::format(
      "center_m: {}, size_m: {}, heading_deg: {:.4f}, wall_height_m: {:.3f}, storeys: {}, "
      "style: {}, roof: {}, bay_m: {:.3f}, window_depth_m: {:.3f}, arcade_depth_m: {:.3f}, "
      "doors: {}, repeat: {}",
      Pair(b.center_m), Pair(b.size_m), b.heading_deg, b.wall_height_m, b.storeys,
      kStyles[static_cast<int>(b.style)], kRoofs[static_cast<int>(b.roof)], b.bay_m,
      b.window_depth_m, b.arcade_depth_m, b.doors, b.repeat);
}

std::string LineOf(const Room& r) {
  std::string text = fmt::format(
      "center_m: {}, size_m: {}, heading_deg: {:.4f}, height_m: {:.3f}, bay_m: {:.3f}, "
      "pillar_spacing_m: {:.3f}, pillar_size_m: {:.3f}, doors: {}, machines: {}, tables: {}, "
      "shelves: {}, repeat: {}",
      Pair(r.center_m), Pair(r.size_m), r.heading_deg, r.height_m, r.bay_m, r.pillar_spacing_m,
      r.pillar_size_m, r.doors, r.machines, r.tables, r.shelves, r.repeat);
  if (!r.core_m.isZero()) text += ", core_m: " + Pair(r.core_m);
  return text;
}

std::string LineOf(const Barrier& b) {
  return fmt::format("from_m: {}, to_m: {}, kind: {}, height_m: {:.3f}, thickness_m: {:.3f}",
                     Pair(b.from_m), Pair(b.to_m), b.kind == BarrierKind::kWall ? "wall" : "fence",
                     b.height_m, b.thickness_m);
}

std::string LineOf(const Pole& p) {
  return fmt::format(
      "position_m: {}, height_m: {:.3f}, diameter_m: {:.3f}, heading_deg: {:.3f}, lamp: {}",
      Pair(p.position_m), p.height_m, p.diameter_m, p.heading_deg, p.lamp);
}

std::string LineOf(const Tree& t) {
  return fmt::format("position_m: {}, height_m: {:.3f}, crown_radius_m: {:.3f}, leaves: {}",
                     Pair(t.position_m), t.height_m, t.crown_radius_m, t.leaves);
}

std::string LineOf(const Car& c) {
  return fmt::format("position_m: {}, heading_deg: {:.3f}, length_m: {:.3f}", Pair(c.position_m),
                     c.heading_deg, c.length_m);
}

std::string LineOf(const StationSite& s) {
  return fmt::format("id: {}, position_m: {}, height_m: {:.3f}, heading_deg: {:.3f}", s.id,
                     Pair(s.position_m), s.height_m, s.heading_deg);
}

std::string LineOf(const ControlSite& c) {
  return fmt::format(
      "id: {}, position_m: [{}, {}, {}], sigma_m: {}, measured_sigma_m: {}, role: {}", c.id,
      c.position_m.x(), c.position_m.y(), c.position_m.z(), c.sigma_m, c.measured_sigma_m,
      c.check ? "check" : "control");
}

template <typename T>
std::string List(const std::string& key, const std::vector<T>& items, const char* indent = "") {
  if (items.empty()) return {};
  std::string text = fmt::format("{}{}:\n", indent, key);
  for (const T& item : items) text += fmt::format("{}  - {{{}}}\n", indent, LineOf(item));
  return text;
}

std::string TextOf(const Scanner& s) {
  constexpr const char* kOrientations[] = {"levelled", "random_heading", "random_so3"};
  return fmt::format(
      "scanner: {{step_deg: {}, min_elevation_deg: {}, max_elevation_deg: {}, min_range_m: {}, "
      "max_range_m: {}, range_sigma_m: {}, range_sigma_ppm: {}, beam_diameter_m: {}, "
      "beam_divergence_deg: {}, mixed_pixels: {}, mixing_m: {}, dropout: {}, level_sigma_deg: {}, "
      "orientation: {}}}\n",
      s.step_deg, s.min_elevation_deg, s.max_elevation_deg, s.min_range_m, s.max_range_m,
      s.range_sigma_m, s.range_sigma_ppm, s.beam_diameter_m, s.beam_divergence_deg, s.mixed_pixels,
      s.mixing_m, s.dropout, s.level_sigma_deg, kOrientations[static_cast<int>(s.orientation)]);
}

}  // namespace

std::string SceneText(const Scene& scene) {
  constexpr const char* kFormats[] = {"ptx", "ply", "las"};
  std::string text = fmt::format("schema_version: 1\nname: {}\nseed: {}\nformat: {}\n", scene.name,
                                 scene.seed, kFormats[static_cast<int>(scene.format)]);
  text += fmt::format("ground:\n  size_m: {}\n  slope_deg: {}\n  undulation_m: {}\n",
                      scene.ground.size_m, Pair(scene.ground.slope_deg), scene.ground.undulation_m);
  text += List("kerbs", scene.ground.kerbs, "  ");
  text += List("buildings", scene.buildings) + List("rooms", scene.rooms) +
          List("barriers", scene.barriers) + List("poles", scene.poles) +
          List("trees", scene.trees) + List("cars", scene.cars);
  const People& people = scene.people;
  if (people.count > 0) {
    text += fmt::format("moving: {{people: {}, area_m: [{}, {}, {}, {}]}}\n", people.count,
                        people.min_m.x(), people.min_m.y(), people.max_m.x(), people.max_m.y());
  }
  if (scene.crs) {
    text += fmt::format("crs: {{horizontal: {}, origin: [{}, {}, {}], heading_deg: {}}}\n",
                        scene.crs->horizontal, scene.crs->origin.x(), scene.crs->origin.y(),
                        scene.crs->origin.z(), scene.crs->heading_deg);
  }
  return text + TextOf(scene.scanner) + List("stations", scene.stations) +
         List("control", scene.control);
}

}  // namespace backsight
