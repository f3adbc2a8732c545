#pragma once

#include <string>
#include <vector>

#include "core/execution.h"

namespace backsight {

/// How another program ended.
struct ProgramEnd {
  std::string fault;   ///< why it could not be started; empty where it was
  int exit_code = -1;  ///< 128 + signal where a signal ended it
  std::string out;     ///< what it wrote on stdout
  std::string err;     ///< and on stderr
};

/// Runs the program `words[0]`, found by PATH, with the other words as its arguments, and waits for
/// its end. No shell is involved: words may hold anything but zero bytes. The program reads
/// nothing, and a Ctrl-C meant for this process does not reach it: where CheckStop of `context`,
/// which is asked ten times a second, throws Interrupted or OverTimeLimit, the program and what it
/// started are killed, and the exception passes on.
ProgramEnd RunProgram(const std::vector<std::string>& words, const ExecutionContext& context);

}  // namespace backsight
