#include "pipeline/sbatch_options.h"

#include <fmt/format.h>

#include <array>
#include <string_view>

#include "core/error.h"
#include "pipeline/option_words.h"

namespace backsight {
namespace {

/// An option that is the run's own, and what a user can do who wants it.
struct Reserved {
  char letter;  ///< 0: it has none
  std::string_view name;
  const char* remedy;
};

constexpr std::array<Reserved, 8> kReserved = {{
    {'a', "array", "leave it out: stations and pairs are arrays already"},
    {'d', "dependency",
     "leave it out; to begin later, give --begin, or --hold and release the jobs"},
    {'W', "wait", "leave it out; --wait of backsight run follows the jobs to their end"},
    {0, "wrap", "leave it out: the jobs run backsight"},
    {0, "test-only", "leave it out; backsight run --dry-run says what would be done"},
    {0, "parsable", "leave it out: the ids of the jobs are printed anyway"},
    {'Q', "quiet", "leave it out; --quiet of backsight run is handed on to the final run"},
    {'M', "clusters", "leave it out; set SLURM_CLUSTERS for Slurm's commands, all of them"},
}};

/// sbatch's letters that take no value, so that others may follow in the same word.
constexpr std::string_view kFlags = "HOQVWhksuv";

[[noreturn]] void Refuse(const std::string& word, const Reserved& option) {
  throw InputError({"--slurm-options",
                    fmt::format("{}: sbatch's --{} is the run's own", word, option.name),
                    "options that leave the run's order of jobs alone", option.remedy});
}

void RefuseLetter(const std::string& word, char letter) {
  for (const Reserved& option : kReserved) {
    if (option.letter == letter) Refuse(word, option);
  }
}

void RefuseName(const std::string& word) {
  const std::string_view name = std::string_view(word).substr(2, word.find('=') - 2);
  for (const Reserved& option : kReserved) {
    if (!name.empty() && option.name.starts_with(name)) Refuse(word, option);
  }
}

}  // namespace

std::vector<std::string> SbatchOptions(const std::string& text) {
  std::vector<std::string> words = SplitWords(text, "--slurm-options");
  for (const std::string& word : words) {
    if (word.starts_with("--")) {
      RefuseName(word);
    } else if (word.starts_with("-")) {
      std::size_t i = 1;
      while (i + 1 < word.size() && kFlags.find(word[i]) != std::string_view::npos) {
        RefuseLetter(word, word[i++]);
      }
      if (i < word.size()) RefuseLetter(word, word[i]);
    }
  }
  return words;
}

}  // namespace backsight
