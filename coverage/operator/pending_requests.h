// Keeps the requests of the display that no state has answered yet. The display's state is always a little
// old, but a person who presses a key twice assumes that the first press has worked. So a request names its
// goal ("pause", "take back view 17"), never "toggle", and two quick presses are two requests.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "coverage/session/capture_request.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

class PendingRequests {
 public:
  explicit PendingRequests(CaptureRequests& requests) : requests_(requests) {}

  // These send requests to the capture (capture_request.h).
  void Record(bool on);
  void BeginAlthoughChecksFail();
  void Place(const Subject& subject);
  void FindSubject();
  void TakeBack(int view_id);
  void Finish();

  // These return what holds by the state and by what was requested since: whether the capture records, its
  // subject (none: there is none), and the newest view that is not taken back (none: no view is left).
  bool Records(const CaptureState& state) const;
  std::optional<Subject> SubjectOf(const CaptureState& state) const;
  bool IsTakenBack(int view_id) const { return taken_back_.contains(view_id); }
  std::optional<int> LastView(const CaptureState& state) const;

  // Returns a number that changes with every Record(), so that one can tell whether there was another since.
  std::uint64_t record_ticket() const { return record_.ticket; }

 private:
  template <typename Value>
  struct Pending {
    Value value{};
    std::uint64_t ticket = 0;  // of the request; 0: none yet
    bool IsOpen(const CaptureState& state) const { return ticket > state.requests_answered; }
  };
  CaptureRequests& requests_;
  Pending<bool> record_;
  Pending<std::optional<Subject>> subject_;
  std::set<int> taken_back_;  // no number is given twice
};

}  // namespace ulf::coverage
