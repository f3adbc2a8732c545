#include "core/error.h"
#include "io/utf8.h"
#include "io/xyz_reader.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

std::vector<std::string> Seeds() {
  return {"1 2 3\n-4.5 +5e2 6\nnan inf 0\n",
          "# any\n//X Y Z I R G B\n1 2 3 0.5 255 0 17\n\n4 5 6 1 1 2 3\n",
          "\"x\";\"y\";\"z\";\"red\";\"green\";\"blue\"\n1;2;3;0.5;0.25;1\n4;5;6;0;0;0\n",
          "z,y,x,reflectance\r\n1,2,3,-100\r\n4,5,6,1e9\r\n",
          "\xEF\xBB\xBF"
          "1\t2\t3\t65535\t1\n4\t5\t6\t1\t1",
          "a 1 2 3 b\n0.5 4 5 6 7\n",
          "1 2 3 40000 256 65535 4000\n4 5 6 0 0 0 300\n"};
}

/// With the columns guessed, and with three given between two that may hold anything.
void Read(const std::string& path) {
  using enum TextColumn;
  try {
    ReadScans(path, [](const std::string& file, int) {
      return OpenXyz(file, {kSkip, kX, kY, kZ, kSkip});
    });
  } catch (const InputError& error) {
    BACKSIGHT_CHECK(CleanUtf8(error.what()) == error.what(), "a message that is not UTF-8");
  }
  ReadScans(path, [](const std::string& file, int) { return OpenXyz(file); });
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&Read, &Seeds, &AsItIs}; }

}  // namespace backsight
