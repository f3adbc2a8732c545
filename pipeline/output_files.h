#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/execution.h"
#include "io/run_records.h"
#include "io/survey_project.h"

namespace backsight {

/// Where results go unless the command line says otherwise: out/ beside the project file.
std::string UsualOutDirectory(const std::string& project_path);

/// Where finished work is kept unless the command line says otherwise: work/ beside the project.
std::string UsualWorkDirectory(const std::string& project_path);

/// Removes what a killed run left half written of outputs of this project.
void RemoveTemporaries(const SurveyProject& project, const std::string& out_directory);

/// Removes half written artifacts. Nobody else may be writing some.
void RemoveHalfWrittenArtifacts(const std::string& work_directory);

/// The merged clouds a run writes: those of the project, where it does not say merged.las in
/// `out_directory`.
std::vector<CloudOutput> MergedOutputs(const SurveyProject& project,
                                       const std::string& out_directory);

/// The clouds of single stations a run may write, in the order of the stations; none where the
/// project wants none.
std::vector<CloudOutput> StationOutputs(const SurveyProject& project);

/// MergedOutputs, then StationOutputs.
std::vector<CloudOutput> AllClouds(const SurveyProject& project, const std::string& out_directory);

/// Those of AllClouds that a network makes whose stations are in the given components (from 0;
/// below 0: not placed), with a merged cloud for every component.
std::vector<CloudOutput> CloudsOfNetwork(const SurveyProject& project,
                                         const std::string& out_directory,
                                         const std::vector<int>& component);

/// A file as it lies on the disk now; absent if it cannot be looked at.
std::optional<WrittenCloud> DescribeFile(const std::string& path);

/// Throws InputError where the usual merged cloud could be written over a scan or a cloud of a
/// station; names that the project file gives are looked at when it is read.
void RequireFreeNames(const SurveyProject& project, const std::string& out_directory);

/// What the report says of `files` that an earlier run left under names of this one.
std::string StaleWarning(const std::string& files);

/// Looks for clouds of earlier runs that could be taken for parts of this one: names that the
/// merged outputs may have (components, numbered parts) and station clouds, but not in `written`.
/// Where this run wrote the same output under other names, those that are provably of an earlier
/// run are removed: listed in its manifest (`earlier`) and of the same size and time of change
/// still. All others stay, and a warning names them; so it does those of `earlier` whose output
/// the project no longer has. Scans of the project are never touched.
std::vector<std::string> ClearStaleClouds(const SurveyProject& project,
                                          const std::string& out_directory,
                                          const std::vector<WrittenCloud>& earlier,
                                          const std::vector<OutputRecord>& written,
                                          const ExecutionContext& context);

}  // namespace backsight
