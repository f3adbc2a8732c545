#include "core/option_visitor.h"

#include <gtest/gtest.h>

#include <string>

namespace backsight {
namespace {

struct SampleOptions {
  double edge_m = 0.1;
  int steps = 20;
  bool robust = true;
  int mode = 1;
};

OptionSection Section(SampleOptions& options) {
  return {"sample", "a section for this test", [&options](OptionVisitor& v) {
            v.Real("edge_m", options.edge_m, "m", 0.01, 1.0, "an edge");
            v.Integer("steps", options.steps, "1", 0, 100, "steps");
            v.Flag("robust", options.robust, "whether");
            v.Choice("mode", options.mode, {"micro", "overlap"}, "which");
          }};
}

TEST(CanonicalText, ListsEveryFieldInOrder) {
  SampleOptions options;
  EXPECT_EQ(CanonicalText(Section(options)),
            "sample.edge_m=0.1\nsample.steps=20\nsample.robust=true\nsample.mode=overlap\n");
  options = {.edge_m = 2.0, .steps = -3, .robust = false, .mode = 0};
  EXPECT_EQ(CanonicalText(Section(options)),
            "sample.edge_m=2\nsample.steps=-3\nsample.robust=false\nsample.mode=micro\n");
}

TEST(CanonicalText, KeepsEveryBitOfReals) {
  for (const double value : {1.0 / 3.0, 0.1 + 0.2, 1e-300, 123456789.123456789}) {
    SampleOptions options{.edge_m = value};
    const std::string text = CanonicalText(Section(options));
    EXPECT_EQ(std::stod(text.substr(text.find('=') + 1)), value);
  }
}

TEST(CanonicalText, ReadsOnly) {
  SampleOptions options{.edge_m = 0.7, .steps = 5, .robust = false, .mode = 0};
  CanonicalText(Section(options));
  EXPECT_EQ(options.edge_m, 0.7);
  EXPECT_EQ(options.steps, 5);
  EXPECT_FALSE(options.robust);
  EXPECT_EQ(options.mode, 0);
}

}  // namespace
}  // namespace backsight
