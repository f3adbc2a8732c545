#include "core/option_visitor.h"

#include <fmt/format.h>

namespace backsight {
namespace {

class TextWriter : public OptionVisitor {
 public:
  explicit TextWriter(std::string prefix) : prefix_(std::move(prefix)) {}
  void Real(std::string_view key, double& value, std::string_view, double, double,
            std::string_view) override {
    Line(key, fmt::format("{}", value));
  }
  void Integer(std::string_view key, int& value, std::string_view, int, int,
               std::string_view) override {
    Line(key, fmt::format("{}", value));
  }
  void Flag(std::string_view key, bool& value, std::string_view) override {
    Line(key, value ? "true" : "false");
  }
  void Choice(std::string_view key, int& value, const std::vector<std::string>& names,
              std::string_view) override {
    Line(key, names.at(static_cast<std::size_t>(value)));
  }
  std::string text;

 private:
  void Line(std::string_view key, std::string_view value) {
    text += fmt::format("{}.{}={}\n", prefix_, key, value);
  }
  std::string prefix_;
};

}  // namespace

std::string CanonicalText(const OptionSection& section) {
  TextWriter writer(section.name);
  section.visit(writer);
  return writer.text;
}

}  // namespace backsight
