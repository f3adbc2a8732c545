#include "pipeline/run_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/survey_pipeline.h"

namespace backsight {
namespace {

using ::testing::HasSubstr;

/// Four stations in one network, with a sigma of 1 mm along each axis.
RunRecord WholeRun() {
  RunRecord run;
  for (int s = 0; s < 4; ++s) {
    PoseRecord pose;
    pose.status = StationStatus::kRegistered;
    pose.component = 0;
    Matrix6d covariance = Matrix6d::Zero();
    covariance.diagonal().tail<3>().setConstant(1e-6);
    pose.covariance = covariance;
    run.poses.push_back(pose);
  }
  return run;
}

RunRecord Judged(RunRecord run, const Completion& completion = {}) {
  Judge(completion, &run);
  return run;
}

TEST(Judge, WholeRunsAreComplete) {
  const RunRecord run = Judged(WholeRun());
  EXPECT_EQ(run.exit_code, kComplete);
  EXPECT_EQ(run.verdict, "Complete: all 4 stations placed in one network.");
}

TEST(Judge, WhatFailedIsNeverCalledComplete) {
  const RunRecord failed = Judged(WholeRun(), {.failed_pairs = 2});
  EXPECT_EQ(failed.exit_code, kPartial);
  EXPECT_THAT(failed.verdict, HasSubstr("Partial: all 4 stations placed"));
  EXPECT_THAT(failed.verdict, HasSubstr("2 pair(s)"));
  const RunRecord provisional = Judged(WholeRun(), {.converged = false});
  EXPECT_EQ(provisional.exit_code, kPartial);
  EXPECT_THAT(provisional.verdict, HasSubstr("did not converge"));

  RunRecord apart = WholeRun();
  apart.poses[3].component = 1;
  EXPECT_EQ(Judged(apart).exit_code, kPartial);
  EXPECT_THAT(Judged(apart).verdict, HasSubstr("3 of 4 stations"));

  RunRecord floating = WholeRun();
  floating.georeference.emplace_back().status = "too_few_points";
  EXPECT_EQ(Judged(floating).exit_code, kPartial);
  EXPECT_THAT(Judged(floating).verdict, HasSubstr("does not tie"));

  RunRecord unreadable = WholeRun();
  for (int s = 0; s < 3; ++s) {
    unreadable.poses[static_cast<std::size_t>(s)].status = StationStatus::kUnreadable;
  }
  EXPECT_EQ(Judged(unreadable).exit_code, kNoUsableInput);
}

TEST(Judge, AFailedGateOutranksAPartialResult) {
  RunRecord run = WholeRun();
  run.poses[3].component = 1;
  run.gates = {{"max_station_sigma_mm", "1 mm", "2 mm", false}};
  EXPECT_EQ(Judged(run).exit_code, kGateFailed);
  EXPECT_THAT(Judged(run).verdict, HasSubstr("Gate max_station_sigma_mm failed: 2 mm"));
  run.gates.push_back({"max_check_rmse_mm", "5 mm, 3D", "no check points", false});
  EXPECT_EQ(
      Judged(run).verdict,
      "Gate max_station_sigma_mm failed: 2 mm (limit 1 mm); gate max_check_rmse_mm failed: no "
      "check points (limit 5 mm, 3D). 3 of 4 stations placed.");
}

TEST(JudgeGates, SigmasMustBeKnownAndSmall) {
  GateSpec gates;
  gates.max_station_sigma_mm = 1.5;
  RunRecord run = WholeRun();
  const auto judge = [&] { return JudgeGates(gates, run.poses, {}).at(0); };
  EXPECT_TRUE(judge().passed);
  EXPECT_EQ(judge().value, "1.00 mm");
  (*run.poses[2].covariance)(4, 4) = 4e-6;
  EXPECT_FALSE(judge().passed);
  EXPECT_EQ(judge().value, "2.00 mm");
  run.poses[2].covariance.reset();
  EXPECT_FALSE(judge().passed);
  EXPECT_EQ(judge().value, "1.00 mm, unknown of 1 stations");
  for (PoseRecord& pose : run.poses) pose.status = StationStatus::kNotRegistered;
  EXPECT_FALSE(judge().passed);
  EXPECT_EQ(judge().value, "no station placed");
}

TEST(JudgeGates, SaysWhoseSigmasAreNotOnTheGround) {
  GateSpec gates;
  gates.max_station_sigma_mm = 1.5;
  RunRecord run = WholeRun();
  for (PoseRecord& pose : run.poses)
    pose.ground = GroundPose{{}, *pose.covariance, {0.0, 0.0, 0.0}};
  const std::vector<GeoreferenceRecord> control(1);
  EXPECT_EQ(JudgeGates(gates, run.poses, control).at(0).value, "1.00 mm");
  run.poses[1].ground.reset();
  EXPECT_EQ(JudgeGates(gates, run.poses, control).at(0).value,
            "1.00 mm, relative for 1 stations that control does not tie");
  EXPECT_EQ(JudgeGates(gates, run.poses, {}).at(0).value, "1.00 mm");
}

TEST(JudgeGates, NamesTheStationsThatAreNotPlaced) {
  GateSpec gates;
  gates.require_all_stations = true;
  RunRecord run = WholeRun();
  const auto judge = [&] { return JudgeGates(gates, run.poses, {}).at(0); };
  EXPECT_TRUE(judge().passed);
  EXPECT_EQ(judge().value, "4 of 4 placed together");
  run.poses[1].station = "B";
  run.poses[2].station = "C";
  run.poses[1].status = StationStatus::kUnreadable;
  run.poses[2].component = 1;
  EXPECT_FALSE(judge().passed);
  EXPECT_EQ(judge().value, "2 of 4 placed together, without B (its scan cannot be used), C");
  run.gates = {judge()};
  EXPECT_EQ(Judged(run).verdict,
            "Gate require_all_stations failed: 2 of 4 placed together, without B (its scan cannot "
            "be used), C (limit all).");
}

TEST(JudgeGates, CheckPointsMustBeThere) {
  GateSpec gates;
  gates.max_check_rmse_mm = 5.0;
  GeoreferenceRecord good, bad;
  good.status = bad.status = "georeferenced";
  good.check.points = bad.check.points = 4;
  good.check.rmse_3d_m = 0.002;
  bad.check.rmse_3d_m = 0.0061;
  EXPECT_FALSE(JudgeGates(gates, {}, {}).at(0).passed);
  EXPECT_TRUE(JudgeGates(gates, {}, {good}).at(0).passed);
  EXPECT_FALSE(JudgeGates(gates, {}, {good, bad}).at(0).passed);
  bad.status = "contradictory";
  bad.variance_factor = 9.0;
  EXPECT_EQ(JudgeGates({}, {}, {bad}).at(0).name, "control_agrees");
  EXPECT_THAT(JudgeGates({}, {}, {bad}).at(0).value, HasSubstr("3.0 times"));
}

}  // namespace
}  // namespace backsight
