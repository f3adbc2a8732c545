#include "pipeline/prepared_station.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "stages/surface_choice.h"
#include "stages/surface_refinement.h"
#include "tests/support/hall_scene.h"

namespace backsight {
namespace {

TEST(PreparedStation, MakesEverythingOnceAndAnewInACopy) {
  const HallScene scene(1, {});
  const HallStation station(scene, {-5.0, -2.5, 1.6}, 10);
  const PreparedStation prepared;
  const auto planes = prepared.Planes(station.surface(), {});
  EXPECT_GT(planes->roots(), 10U);
  EXPECT_EQ(prepared.Planes(station.surface(), {}), planes);
  FineOptions coarser;
  coarser.root_edge *= 2.0;
  const auto others = prepared.Planes(station.surface(), coarser);
  EXPECT_LT(others->roots(), planes->roots());
  EXPECT_EQ(prepared.Planes(station.surface(), {}), planes);

  const std::vector<std::uint32_t>& surfaces = prepared.Surfaces(station.surface());
  EXPECT_EQ(surfaces, ChooseSurfaces(station.features.normals, kRefinedSurfaces));
  EXPECT_EQ(&prepared.Surfaces(station.surface()), &surfaces);

  const double cell_m = prepared.PlanCell(station.model, station.features);
  EXPECT_EQ(cell_m, PlanCellFor(station.model, station.features));
  const PlanView& plan = prepared.Plan(station.model, station.features, cell_m);
  EXPECT_EQ(&prepared.Plan(station.model, station.features, cell_m), &plan);
  EXPECT_EQ(prepared.Plan(station.model, station.features, 2.0 * cell_m).cell_m(), 2.0 * cell_m);

  const PreparedStation copy = prepared;
  EXPECT_NE(copy.Planes(station.surface(), {}), planes);

  const PreparedStation alone;
  const std::weak_ptr<const PlaneTree> kept = alone.Planes(station.surface(), {});
  EXPECT_FALSE(kept.expired());
}

TEST(PreparedStation, StationsThatShareKeepThePlanesUsedLast) {
  const HallScene scene(1, {});
  const HallStation station(scene, {-5.0, -2.5, 1.6}, 10);
  const auto last = std::make_shared<LastPlanes>();
  const std::vector<PreparedStation> stations(2, PreparedStation(last));
  const auto planes_of = [&](std::size_t s) { return stations[s].Planes(station.surface(), {}); };
  std::weak_ptr<const PlaneTree> first = planes_of(0);
  EXPECT_FALSE(first.expired());
  std::weak_ptr<const PlaneTree> second = planes_of(1);
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(second.expired());

  const auto at_work = planes_of(0);
  EXPECT_TRUE(second.expired());
  second = planes_of(1);
  EXPECT_EQ(planes_of(0), at_work);  // it was not made anew
  EXPECT_EQ(at_work->roots(), planes_of(1)->roots());
}

TEST(LastPlanes, AreGoneBeforeOthersAreMadeButForThoseAtWork) {
  const HallScene scene(1, {});
  const HallStation station(scene, {-5.0, -2.5, 1.6}, 10);
  LastPlanes last;
  std::weak_ptr<const PlaneTree> seen;
  bool was_gone = false;
  const auto make = [&] {
    was_gone = seen.expired();
    return MakePlaneTree(station.surface(), {});
  };
  auto at_work = last.Make(make);
  last.Use(at_work);
  seen = at_work;
  last.Make(make);
  EXPECT_FALSE(was_gone);
  at_work = nullptr;
  EXPECT_FALSE(seen.expired()) << "the last ones stay";
  last.Make(make);
  EXPECT_TRUE(was_gone);
}

}  // namespace
}  // namespace backsight
