#include "io/option_reader.h"

#include <utility>

namespace backsight {
namespace {

class YamlOptionReader : public OptionVisitor {
 public:
  explicit YamlOptionReader(YamlValue map) : map_(std::move(map)) {}

  void Real(std::string_view key, double& value, std::string_view unit, double min, double max,
            std::string_view) override {
    value = map_.Optional(std::string(key)).Real(value, {min, max, unit});
  }
  void Integer(std::string_view key, int& value, std::string_view unit, int min, int max,
               std::string_view) override {
    value = map_.Optional(std::string(key)).Integer(value, min, max, unit);
  }
  void Flag(std::string_view key, bool& value, std::string_view) override {
    value = map_.Optional(std::string(key)).Flag(value);
  }
  void Choice(std::string_view key, int& value, const std::vector<std::string>& names,
              std::string_view) override {
    value = map_.Optional(std::string(key)).Choice(value, names);
  }

 private:
  YamlValue map_;
};

}  // namespace

void ReadOptions(const YamlValue& root, const std::vector<OptionSection>& sections) {
  for (const OptionSection& section : sections) {
    const YamlValue map = root.Optional(section.name);
    if (!map.present() || map.IsNull()) continue;
    YamlOptionReader reader(map);
    section.visit(reader);
  }
}

}  // namespace backsight
