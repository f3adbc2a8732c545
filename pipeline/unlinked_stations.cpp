#include "pipeline/unlinked_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "io/html_table.h"
#include "io/link_reasons.h"
#include "pipeline/name_list.h"

namespace backsight {
namespace {

using Members = std::set<std::string>;

/// Whether the link would join one of them with another station.
bool LeadsOut(const LinkRecord& link, const Members& members) {
  return members.contains(link.source) != members.contains(link.target);
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

/// What became of all pairs that lead out: of those that were tried, or else why none was.
std::string DescribePairs(const std::vector<LinkRecord>& links, const Members& members) {
  std::vector<std::string> tried, skipped;
  for (const LinkRecord& link : links) {
    if (!LeadsOut(link, members)) continue;
    if (link.status == LinkStatus::kSkipped) {
      skipped.push_back(link.reason);
    } else {
      tried.push_back(link.status == LinkStatus::kFailed ? "failed" : link.reason);
    }
  }
  const char* const whose = members.size() == 1 ? "its pairs" : "the pairs that lead there";
  if (!tried.empty()) {
    return fmt::format("; of {} pair(s) that were tried: {}", tried.size(), CountReasons(tried));
  }
  return fmt::format("; none of {} was tried{}", whose,
                     skipped.empty() ? "" : ": " + CountReasons(skipped));
}

/// "; doubtful: S9 - S8 (far from start), ..." with what could confirm them: first the one of which
/// least was seen through, which places that only look alike seldom are. Empty where there is none.
std::string DescribeDoubtful(const std::vector<LinkRecord>& links, const Members& members) {
  std::vector<const LinkRecord*> doubtful;
  bool untried = false;
  for (const LinkRecord& link : links) {
    if (!LeadsOut(link, members)) continue;
    untried |= link.status == LinkStatus::kSkipped && link.reason != "unusable_station";
    if (link.status == LinkStatus::kDoubtful) doubtful.push_back(&link);
  }
  if (doubtful.empty()) return "";
  std::stable_sort(doubtful.begin(), doubtful.end(),
                   [](const auto* a, const auto* b) { return a->conflict < b->conflict; });
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> names;
  for (const LinkRecord* link : doubtful) {
    names.push_back(fmt::format("{} - {} ({})", link->source, link->target,
                                link->reason.empty() ? "unconfirmed" : CodeWords(link->reason)));
  }
  return fmt::format(
      "; doubtful: {}{}, which no loop of other links confirms: a further station that overlaps "
      "with both sides could{}",
      FirstNames(names, kNamed), names.size() > 1 ? ", first of which least was seen through" : "",
      untried ? ", or pairs that were not tried (pairs: include)" : "");
}

}  // namespace

std::string DescribeGap(const std::vector<LinkRecord>& links, const Members& members) {
  return DescribeDoubtful(links, members) + DescribePairs(links, members);
}

std::string DescribeUnlinked(const std::vector<LinkRecord>& links, const std::string& station) {
  return "no accepted link to any other station" + DescribeGap(links, {station});
}

}  // namespace backsight
