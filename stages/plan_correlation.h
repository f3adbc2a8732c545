#pragma once

#include <cstddef>
#include <vector>

#include "core/rigid_transform.h"
#include "stages/plan_view.h"

namespace backsight {

struct PlanCorrelationOptions {
  int turns = 72;            ///< headings that are told apart: a whole turn in equal steps
  int tried_turns = 72;      ///< of those, the ones under which most walls face alike
  std::size_t matches = 10;  ///< motions that are returned
};

/// A motion between two levelled stations and how well their plans agree under it: 1 if every wall
/// of either lies on a wall of the other that faces alike, less by what one scanner saw through.
struct PlanMatch {
  RigidTransform target_from_source;  ///< z by the lowest surfaces of both
  double score = 0.0;
};

/// Motions that lay two views from above on each other: for each heading all translations by whole
/// cells that keep the stations within half a view of each other are scored (correlative scan
/// matching: Olson 2009, doi 10.1109/ROBOT.2009.5152375), here with what either scanner saw
/// through. Needs no features: where pairs share too little for key points to find each other,
/// walls and free space still fit in one way. The best first, no two within 10 deg and two cells.
/// Good to a cell and half a step of heading. Both views must have cells of one size. Exact in
/// integers. Time O(headings * cells * samples), 0.3 ms a heading for 100 samples.
std::vector<PlanMatch> CorrelatePlans(const PlanView& source, const PlanView& target,
                                      const PlanCorrelationOptions& options);

}  // namespace backsight
