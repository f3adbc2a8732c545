#include "pipeline/option_words.h"

#include <optional>

#include "core/error.h"

namespace backsight {

std::vector<std::string> SplitWords(std::string_view text, const std::string& where) {
  std::vector<std::string> words;
  std::optional<std::string> word;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool escapes = c == '\\' && quote != '\'' && i + 1 < text.size() &&
                         (quote == 0 || text[i + 1] == '"' || text[i + 1] == '\\');
    if (escapes) {
      word = word.value_or("") + text[++i];
    } else if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
      word = word.value_or("");  // which may stay empty
    } else if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == ' ' || c == '\t' || c == '\n')) {
      if (word) words.push_back(*word);
      word.reset();
    } else {
      word = word.value_or("") + c;
    }
  }
  if (quote != 0) {
    throw InputError({where, std::string("a quote that is not closed: ") + quote,
                      "words, in quotes where they hold blanks", "close it"});
  }
  if (word) words.push_back(*word);
  return words;
}

}  // namespace backsight
