#include "pipeline/unlinked_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "io/html_table.h"
#include "io/link_reasons.h"
#include "pipeline/name_list.h"

namespace backsight {
namespace {

bool IsOf(const LinkRecord& link, const std::string& station) {
  return link.source == station || link.target == station;
}

/// "3 ambiguous (several placements fit alike, ...), 1 low overlap (...)": the most frequent ones.
std::string CountReasons(const std::vector<std::string>& reasons) {
  constexpr std::size_t kNamed = 3;
  std::map<std::string, int> count;
  for (const std::string& reason : reasons) ++count[reason];
  std::vector<std::pair<std::string, int>> frequent(count.begin(), count.end());
  std::stable_sort(frequent.begin(), frequent.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (std::size_t r = 0; r < std::min(kNamed, frequent.size()); ++r) {
    const auto& [reason, pairs] = frequent[r];
    const std::string_view meaning = MeaningOfReason(reason);
    text += fmt::format("{}{} {}{}", r == 0 ? "" : ", ", pairs, CodeWords(reason),
                        meaning.empty() ? "" : fmt::format(" ({})", meaning));
  }
  return text + (frequent.size() > kNamed ? " and other reasons" : "");
}

/// What became of all its pairs: of those that were tried, or else why none was.
std::string DescribePairs(const std::vector<LinkRecord>& links, const std::string& station) {
  std::vector<std::string> tried, skipped;
  for (const LinkRecord& link : links) {
    if (!IsOf(link, station)) continue;
    if (link.status == LinkStatus::kSkipped) {
      skipped.push_back(link.reason);
    } else {
      tried.push_back(link.status == LinkStatus::kFailed ? "failed" : link.reason);
    }
  }
  if (!tried.empty()) {
    return fmt::format("; of {} pair(s) that were tried: {}", tried.size(), CountReasons(tried));
  }
  return "; none of its pairs was tried" + (skipped.empty() ? "" : ": " + CountReasons(skipped));
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
      FirstNames(others), untried ? ", or pairs that were not tried (pairs: include)" : "");
}

std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station) {
  return "no accepted link to any other station" + DescribeDoubtful(links, station) +
         DescribePairs(links, station);
}

}  // namespace backsight
