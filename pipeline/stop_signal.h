#pragma once

#include <stop_token>

namespace backsight {

/// Makes SIGINT and SIGTERM request a stop instead of killing the process, from now on.
std::stop_token InstallStopSignals();

/// The signal that asked for the stop, 0 if none did.
int StopSignal();

}  // namespace backsight
