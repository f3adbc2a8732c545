#include "pipeline/unlinked_stations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "io/html_table.h"
#include "io/link_reasons.h"

namespace backsight {
namespace {

bool IsOf(const LinkRecord& link, const std::string& station) {
  return link.source == station || link.target == station;
}

/// "; of its 5 pairs 4 ambiguous (several placements fit alike, ...), 1 low overlap (...)".
std::string DescribeTried(const std::vector<LinkRecord>& links, const std::string& station) {
  std::map<std::string, int> count;  // by reason
  int tried = 0;
  for (const LinkRecord& link : links) {
    if (!IsOf(link, station) || link.status == LinkStatus::kSkipped) continue;
    ++tried;
    ++count[link.status == LinkStatus::kFailed ? "failed" : link.reason];
  }
  if (tried == 0) return "; none of its pairs was tried";
  std::vector<std::pair<std::string, int>> frequent(count.begin(), count.end());
  std::stable_sort(frequent.begin(), frequent.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<std::string> reasons;
  for (const auto& [reason, pairs] : frequent) {
    const std::string_view meaning = MeaningOfReason(reason);
    reasons.push_back(fmt::format("{} {}{}", pairs, CodeWords(reason),
                                  meaning.empty() ? "" : fmt::format(" ({})", meaning)));
  }
  return fmt::format("; of {} pair(s) that were tried: {}", tried, fmt::join(reasons, ", "));
}

}  // namespace

std::string DescribeDoubtful(const std::vector<LinkRecord>& links, const std::string& station) {
  std::vector<std::string> others;
  bool untried = false;
  for (const LinkRecord& link : links) {
    if (!IsOf(link, station)) continue;
    untried |= link.status == LinkStatus::kSkipped && link.reason != "unusable_station";
    if (link.status != LinkStatus::kDoubtful) continue;
    others.push_back(link.source == station ? link.target : link.source);
  }
  if (others.empty()) return "";
  return fmt::format(
      "; doubtful ones to {}, which no loop of other links confirms: a further station that "
      "overlaps with both sides could{}",
      fmt::join(others, ", "), untried ? ", or pairs that were not tried (pairs: include)" : "");
}

std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station) {
  return "no accepted link to any other station" + DescribeDoubtful(links, station) +
         DescribeTried(links, station);
}

}  // namespace backsight
