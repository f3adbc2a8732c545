#include "pipeline/stop_signal.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

namespace backsight {
namespace {

std::atomic<int> received_signal{0};

}  // namespace

std::stop_token InstallStopSignals() {
  // A thread waits for the signals, because a stop_source may not be touched in a signal handler.
  static std::stop_source source;
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int signal = 0;
    sigwait(&signals, &signal);
    received_signal = signal;
    source.request_stop();
    sigwait(&signals, &signal);  // asked twice: at once
    _exit(128 + signal);
  }).detach();
  return source.get_token();
}

int StopSignal() { return received_signal; }

}  // namespace backsight
