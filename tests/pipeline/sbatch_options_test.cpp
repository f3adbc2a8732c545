#include "pipeline/sbatch_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"

namespace backsight {
namespace {

std::string Refusal(const std::string& text) {
  try {
    SbatchOptions(text);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(SbatchOptions, AreTakenAsTheyAre) {
  EXPECT_EQ(SbatchOptions("--partition=cpu -A survey --comment='two words' --hold"),
            (std::vector<std::string>{"--partition=cpu", "-A", "survey", "--comment=two words",
                                      "--hold"}));
  for (const char* text : {"", "--wait-all-nodes=1", "--begin=now+1hour", "-pWide", "-J array",
                           "-tMQ", "-Hs", "-D /data", "--qos=quiet"}) {
    EXPECT_EQ(Refusal(text), "") << text;
  }
}

TEST(SbatchOptions, OfTheRunItselfAreRefusedByName) {
  using testing::HasSubstr;
  for (const char* text :
       {"--dependency=afterok:1", "--dependency afterok:1", "--dep=singleton", "-d", "-dafterok:1",
        "-Hd afterok:1", "-p cpu -a 1-3", "--array=1", "-W", "-vW", "--wait", "--wrap=ls",
        "--test-only", "--parsable", "-Q", "--quiet", "-M other", "--clusters=all"}) {
    EXPECT_THAT(Refusal(text), HasSubstr("the run's own")) << text;
  }
  EXPECT_THAT(Refusal("--dep=singleton"),
              testing::AllOf(HasSubstr("--slurm-options"), HasSubstr("--dep=singleton"),
                             HasSubstr("--dependency"), HasSubstr("--begin")));
}

}  // namespace
}  // namespace backsight
