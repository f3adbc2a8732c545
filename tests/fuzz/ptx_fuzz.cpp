#include "io/ptx_reader.h"
#include "tests/fuzz/fuzz_target.h"

namespace backsight {
namespace {

constexpr const char* kUpright =
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
constexpr const char* kTurned =
    "10 -20.5 3\n0 1 0\n-1 0 0\n0 0 1\n"
    "0 1 0 0\n-1 0 0 0\n0 0 1 0\n10 -20.5 3 1\n";

std::vector<std::string> Seeds() {
  const std::string grey = std::string("2\n3\n") + kUpright +
                           "1 2 3 0.5\n0 0 0 0.5\n-1.25 2e1 +3 1\n"
                           "4 5 6 0\n1e-3 0 0 0.25\n7 8 9 2\n";
  const std::string color =
      std::string("1\r\n2\r\n") + kTurned + "1 2 3 0.5 255 0 17\r\n0 0 0 0 0 0 0\r\n";
  const std::string last_line_open = std::string("1\n1\n") + kTurned + "1\t2 3 nan";
  return {grey, color, grey + color, color + "\n" + color + grey, last_line_open};
}

void Read(const std::string& path) {
  ReadScans(path, [](const std::string& file, int scan) { return OpenPtx(file, scan); });
}

}  // namespace

FuzzTarget TargetUnderTest() { return {&Read, &Seeds, &AsItIs}; }

}  // namespace backsight
