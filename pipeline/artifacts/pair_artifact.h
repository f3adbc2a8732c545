#pragma once

#include <string>
#include <string_view>

#include "pipeline/pair_pipeline.h"

namespace backsight {

/// What was found of a pair, as bytes; its stations are the caller's to know.
std::string PairBytes(const Pair& pair);

/// Replaces all of the pair but its stations. Throws DamagedArchive.
void RestorePair(std::string_view bytes, Pair* pair);

}  // namespace backsight
