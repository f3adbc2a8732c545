#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/execution.h"
#include "io/artifact_store.h"
#include "io/survey_project.h"
#include "pipeline/run_plan.h"

namespace backsight {

/// Room that a run takes on one file system.
struct DiskNeed {
  std::string path;             ///< a folder on it
  std::uint64_t least = 0;      ///< bytes
  std::uint64_t likely = 0;     ///< bytes
  std::uint64_t available = 0;  ///< to this user
};

/// What a run takes at least and probably, as far as headers and finished stations tell.
struct ResourceNeeds {
  std::vector<DiskNeed> disks;
  std::uint64_t least_memory = 0;     ///< bytes
  std::uint64_t likely_memory = 0;    ///< bytes
  std::uint64_t physical_memory = 0;  ///< of this machine
};

/// `plan` says which outputs need not be written; without one these are all that lie as they were
/// written.
ResourceNeeds EstimateNeeds(const SurveyProject& project, const std::string& out_directory,
                            const ArtifactStore& store, const RunPlan* plan = nullptr,
                            const ExecutionContext& context = ExecutionContext());

/// The disk or the memory cannot suffice; the message has the figures.
class NoRoom : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What to say where memory runs out outside a station or a pair, at `place`.
NoRoom MemoryUsedUp(const std::string& place, double memory_gb);

/// Throws NoRoom where the least that a run takes is more than there is, of disk, of `memory_gb` or
/// of the machine's memory; warns where what it takes probably is.
void RequireRoom(const ResourceNeeds& needs, double memory_gb, const ExecutionContext& context);

/// Has all threads of the context started, so that none needs memory for that later.
void WakeThreads(const ExecutionContext& context);

/// From now on this process gets no more than `memory_gb` (1e9 bytes) of memory, of which the
/// program itself takes a part, besides the stacks of its threads: what asks for more gets
/// std::bad_alloc. False where the system does not grant such a limit.
bool LimitMemory(double memory_gb, int threads);

}  // namespace backsight
