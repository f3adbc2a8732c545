#include "stages/simulation/facade.h"

#include <algorithm>
#include <cmath>

#include "stages/simulation/opening.h"

namespace backsight {
namespace {

struct StyleTraits {
  double window_width = 0.45;   // share of the bay
  double window_height = 0.55;  // share of the storey
  double sill_height = 0.28;    // share of the storey
  double blind_share = 0.0;
  double shutter_share = 0.0;
  double balcony_share = 0.0;
  int panes = 2;
  bool sills = false;
  bool courses = false;    // a string course between storeys
  bool pilasters = false;  // between bays
};

StyleTraits TraitsOf(FacadeStyle style) {
  switch (style) {
    case FacadeStyle::kMasonry:
      return {0.42, 0.56, 0.26, 0.08, 0.3, 0.06, 2, true, true, false};
    case FacadeStyle::kModern:
      return {0.72, 0.6, 0.2, 0.06, 0.0, 0.28, 3, false, false, false};
    case FacadeStyle::kIndustrial:
      return {0.6, 0.4, 0.45, 0.3, 0.0, 0.0, 4, false, false, true};
  }
  return {};
}

/// Vertical cuts between bays: equal where the facade repeats, uneven otherwise.
std::vector<double> BayEdges(const FacadeSpec& spec, Random& random) {
  const int bays = std::max(1, static_cast<int>(std::lround(spec.width_m / spec.bay_m)));
  std::vector<double> edges = {0.0};
  for (int i = 0; i < bays; ++i) {
    edges.push_back(edges.back() + (spec.repeat ? 1.0 : random.Uniform(0.72, 1.28)));
  }
  const double scale = spec.width_m / edges.back();
  for (double& edge : edges) edge *= scale;
  edges.back() = spec.width_m;
  return edges;
}

class FacadeBuilder {
 public:
  FacadeBuilder(const FacadeSpec& spec, const FacadeMaterials& materials,
                const RigidTransform& world_from_panel, Random& random, TriangleMesh& mesh)
      : spec_(spec),
        materials_(materials),
        world_from_panel_(world_from_panel),
        random_(random),
        mesh_(mesh),
        traits_(TraitsOf(spec.style)),
        edges_(BayEdges(spec, random)) {
    for (std::size_t i = 0; i + 1 < edges_.size(); ++i) {
      widths_.push_back(traits_.window_width * Vary(0.14));
    }
    for (int i = 0; i < spec.doors && !spec.repeat; ++i) {
      door_bays_.push_back(random.Index(edges_.size() - 1));
    }
  }

  void Build() {
    double bottom = 0.0;
    if (!spec_.arches) AddFoundation();
    for (std::size_t storey = 0; storey < spec_.storeys_m.size(); ++storey) {
      const double top = bottom + spec_.storeys_m[storey];
      const double height_variation = Vary(0.1);
      for (std::size_t bay = 0; bay + 1 < edges_.size(); ++bay) {
        WallRectangle cell = {edges_[bay], edges_[bay + 1], bottom, top};
        if (spec_.arches && storey == 0) {
          cell.bottom = -spec_.foundation_m;
          AddWallCell(cell, Arch(cell), materials_, world_from_panel_, mesh_);
        } else {
          AddWallCell(cell, Choose(cell, storey, bay, height_variation), materials_,
                      world_from_panel_, mesh_);
        }
      }
      bottom = top;
      const bool last = storey + 1 == spec_.storeys_m.size();
      if (spec_.projections && (traits_.courses || last)) AddCourse(top, last);
    }
    if (traits_.pilasters && spec_.projections) AddPilasters(bottom);
    if (spec_.projections && !spec_.repeat) AddDetails(bottom);
  }

 private:
  double Vary(double share) {
    return spec_.repeat ? 1.0 : random_.Uniform(1.0 - share, 1.0 + share);
  }
  bool Chance(double share) { return !spec_.repeat && random_.Uniform() < share; }

  void Box(double left, double right, double front, double back, double bottom, double top,
           MaterialId material) {
    AddBox(world_from_panel_, {left, front, bottom}, {right, back, top}, material, mesh_);
  }

  void AddFoundation() {
    for (std::size_t bay = 0; bay + 1 < edges_.size(); ++bay) {
      AddWallCell({edges_[bay], edges_[bay + 1], -spec_.foundation_m, 0.0}, {}, materials_,
                  world_from_panel_, mesh_);
    }
  }

  Opening Arch(const WallRectangle& cell) {
    Opening arch;
    arch.kind = OpeningKind::kArch;
    arch.depth_m = 0.6;
    const double pier = std::min(0.35, 0.2 * cell.width()) * Vary(0.15);
    const double top = std::min(cell.top - 0.35, 0.5 * (cell.width() - 2 * pier) + 2.4);
    arch.hole = {cell.left + pier, cell.right - pier, cell.bottom, top};
    return arch;
  }

  Opening Choose(const WallRectangle& cell, std::size_t storey, std::size_t bay,
                 double height_variation) {
    Opening opening;
    if (cell.width() < 1.2 || cell.height() < 1.8) return opening;
    const double middle = 0.5 * (cell.left + cell.right);
    const bool is_door =
        storey == 0 && std::find(door_bays_.begin(), door_bays_.end(), bay) != door_bays_.end();
    if (is_door) {
      const double half = 0.5 * std::min(1.3, 0.7 * cell.width());
      opening.kind = OpeningKind::kDoor;
      opening.depth_m = spec_.window_depth_m * Vary(0.3) + 0.08;
      opening.hole = {middle - half, middle + half, 0.02, std::min(2.3, cell.height() - 0.3)};
      return opening;
    }
    const double half = 0.5 * widths_[bay] * cell.width();
    const double sill = cell.bottom + traits_.sill_height * cell.height();
    const double height = traits_.window_height * height_variation * Vary(0.05) * cell.height();
    opening.kind = Chance(traits_.blind_share) ? OpeningKind::kBlind : OpeningKind::kWindow;
    opening.depth_m = spec_.window_depth_m * Vary(0.3);
    opening.hole = {middle - half, middle + half, sill, std::min(sill + height, cell.top - 0.2)};
    opening.panes = traits_.panes;
    opening.sill = traits_.sills && spec_.projections;
    opening.shutters = spec_.projections && Chance(traits_.shutter_share);
    opening.balcony = spec_.projections && storey > 0 && Chance(traits_.balcony_share);
    return opening;
  }

  void AddCourse(double height, bool cornice) {
    if (cornice) {
      Box(0.0, spec_.width_m, -0.28, 0.05, height - 0.16, height, materials_.trim);
      Box(0.0, spec_.width_m, -0.14, 0.05, height - 0.34, height - 0.16, materials_.trim);
    } else {
      Box(0.0, spec_.width_m, -0.06, 0.05, height - 0.11, height + 0.07, materials_.trim);
    }
  }

  void AddPilasters(double height) {
    for (const double edge : edges_) {
      const double left = std::clamp(edge - 0.2, 0.0, spec_.width_m - 0.4);
      Box(left, left + 0.4, -0.18, 0.05, -spec_.foundation_m, height - 0.34, materials_.trim);
    }
  }

  /// Pipes, signs and boxes: what makes one facade differ from the next.
  void AddDetails(double height) {
    for (int i = 0; i < 2; ++i) {
      const double edge = edges_[random_.Index(edges_.size())];
      const double x = std::clamp(edge, 0.25, spec_.width_m - 0.25);
      AddTube(world_from_panel_ * Eigen::Vector3d(x, -0.12, spec_.arches ? 3.0 : -0.2),
              world_from_panel_ * Eigen::Vector3d(x, -0.12, height - 0.3), 0.05, 0.05, 8,
              materials_.frame, mesh_);
    }
    const int boxes = static_cast<int>(random_.Index(4)) + 1;
    for (int i = 0; i < boxes; ++i) {
      const double x = random_.Uniform(0.5, std::max(0.6, spec_.width_m - 1.6));
      const double z = random_.Uniform(2.4, std::max(2.5, height - 1.2));
      const double width = random_.Uniform(0.4, 1.1);
      const double reach = random_.Uniform(0.12, 0.5);
      const double tall = random_.Uniform(0.25, 0.6);
      Box(x, x + width, -reach, 0.02, z, z + tall, materials_.frame);
    }
  }

  const FacadeSpec& spec_;
  const FacadeMaterials& materials_;
  const RigidTransform& world_from_panel_;
  Random& random_;
  TriangleMesh& mesh_;
  StyleTraits traits_;
  std::vector<double> edges_;
  std::vector<double> widths_;  // of the windows, shares of the bay
  std::vector<std::size_t> door_bays_;
};

}  // namespace

void AddFacade(const FacadeSpec& spec, const FacadeMaterials& materials,
               const RigidTransform& world_from_panel, Random& random, TriangleMesh& mesh) {
  FacadeBuilder(spec, materials, world_from_panel, random, mesh).Build();
}

}  // namespace backsight
