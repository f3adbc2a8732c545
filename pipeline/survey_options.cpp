#include "pipeline/survey_options.h"

namespace backsight {

std::vector<OptionSection> OptionSections(SurveyOptions& options) {
  return {
      {"registration", "how scans are taken in",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.ingest); }},
      {"features", "normals, ISS key points and FPFH descriptors",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.features); }},
      {"pair_selection", "which pairs of stations are registered",
       [&](OptionVisitor& visitor) {
         VisitOptions(visitor, options.pair_selection);
         VisitOptions(visitor, options.pair_ranking);
       }},
      {"matching", "putative correspondences",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.matching); }},
      {"coarse", "node and edge reliability, GNC-Welsch",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.coarse); }},
      {"fine", "planar adjustment with Anderson acceleration",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.fine); }},
      {"verification", "what makes a pair acceptable",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.verification); }},
      {"network", "the pose graph over all stations",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.network); }},
      {"placement_check", "what placed stations say of each other",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.placement_check); }},
      {"refinement", "planar adjustment of all stations together",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.refinement); }},
      {"georeferencing", "how the network is tied to control points",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.georeferencing); }},
      {"moving_objects", "what was gone when other stations looked",
       [&](OptionVisitor& visitor) { VisitOptions(visitor, options.moving_objects); }},
  };
}

}  // namespace backsight
