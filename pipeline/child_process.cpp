#include "pipeline/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "core/error.h"

extern char** environ;

namespace backsight {
namespace {

/// Both ends are closed on exec; the child gets its own copy of the writing end.
class Pipe {
 public:
  Pipe() { BACKSIGHT_CHECK(::pipe2(ends_.data(), O_CLOEXEC) == 0, "no pipe to another program"); }
  ~Pipe() {
    ::close(ends_[0]);
    CloseWriting();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int reading() const { return ends_[0]; }
  int writing() const { return ends_[1]; }
  void CloseWriting() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// What the child begins with: signals as usual, a process group of its own, and the pipes.
class SpawnSettings {
 public:
  SpawnSettings(int out, int err) {
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_init(&files);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    sigset_t pipe_signal;
    sigemptyset(&pipe_signal);
    sigaddset(&pipe_signal, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &pipe_signal);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, out, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&files, err, STDERR_FILENO);
  }
  ~SpawnSettings() {
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawnattr_t attributes{};
  posix_spawn_file_actions_t files{};
};

/// A running program, the first of its process group. All of the group are killed where nobody has
/// waited for its end.
class Child {
 public:
  explicit Child(pid_t process) : process_(process) {}
  ~Child() {
    if (ended_) return;
    ::kill(-process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Returns its exit code.
  int Wait(const ExecutionContext& context) {
    int status = 0;
    while (::waitpid(process_, &status, WNOHANG) != process_) {
      context.CheckStop();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ended_ = true;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  const pid_t process_;
  bool ended_ = false;
};

/// Appends what comes until both ends are closed.
void ReadBoth(int out, int err, const ExecutionContext& context, ProgramEnd* end) {
  constexpr int kPauseMs = 100;
  std::array<pollfd, 2> sources{{{out, POLLIN, 0}, {err, POLLIN, 0}}};
  const std::array<std::string*, 2> texts{&end->out, &end->err};
  std::array<char, 4096> buffer{};
  while (sources[0].fd >= 0 || sources[1].fd >= 0) {
    context.CheckStop();
    const int ready = ::poll(sources.data(), sources.size(), kPauseMs);
    if (ready < 0 && errno != EINTR) return;
    if (ready <= 0) continue;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (sources[i].fd < 0 || sources[i].revents == 0) continue;
      const ssize_t size = ::read(sources[i].fd, buffer.data(), buffer.size());
      if (size > 0) texts[i]->append(buffer.data(), static_cast<std::size_t>(size));
      if (size == 0 || (size < 0 && errno != EINTR)) sources[i].fd = -1;
    }
  }
}

}  // namespace

ProgramEnd RunProgram(const std::vector<std::string>& words, const ExecutionContext& context) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  Pipe out;
  Pipe err;
  const SpawnSettings settings(out.writing(), err.writing());
  ProgramEnd end;
  pid_t process = 0;
  const int failure = ::posix_spawnp(&process, arguments[0], &settings.files, &settings.attributes,
                                     arguments.data(), environ);
  if (failure != 0) {
    end.fault = std::strerror(failure);
    return end;
  }
  Child child(process);
  out.CloseWriting();
  err.CloseWriting();
  ReadBoth(out.reading(), err.reading(), context, &end);
  end.exit_code = child.Wait(context);
  return end;
}

}  // namespace backsight
