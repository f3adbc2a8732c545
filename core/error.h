#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace backsight {

/// Input that Backsight cannot use. The message names where it is, what was found there, what was
/// expected, and what to do about it; every field but `where` may be empty.
class InputError : public std::runtime_error {
 public:
  struct Details {
    std::string where;     ///< file with line or byte offset: "scans/S1.ptx:12"
    std::string found;     ///< what was found there
    std::string expected;  ///< what is allowed there
    std::string remedy;    ///< what the user can do
  };

  explicit InputError(Details details);

  const Details& details() const { return details_; }

 private:
  Details details_;
};

/// Results cannot be written: the disk is full, or the place refuses it. Whatever was being
/// computed is not at fault, so the run stops; what is finished is kept.
class StorageFailure : public InputError {
 public:
  StorageFailure(Details details, bool full) : InputError(std::move(details)), full_(full) {}
  bool full() const { return full_; }  ///< there is no space left

 private:
  bool full_;
};

/// The user or the system asked the run to stop; carries no fault.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// A unit of work took longer than it may; the rest of the run is not at fault.
class OverTimeLimit : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A broken invariant of the program itself: always a bug in Backsight, never the user's fault.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void FailCheck(std::string_view condition, std::string_view file, int line,
                            std::string_view message);

}  // namespace backsight

/// Throws InternalError naming the condition and the place if `condition` does not hold.
#define BACKSIGHT_CHECK(condition, message) \
  ((condition) ? void(0) : ::backsight::FailCheck(#condition, __FILE__, __LINE__, (message)))
