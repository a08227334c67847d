// What the person at the display has asked of the capture. States are behind: until one answers, what is
// pressed next means what the person knows already, that the last wish will be granted. So requests say what
// is wanted ("pause", "take back view 17"), never "the other one", and two quick presses are two wishes.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "coverage/session/capture_request.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

class Wishes {
 public:
  explicit Wishes(CaptureRequests& requests) : requests_(requests) {}

  void Record(bool on);
  void Place(const Subject& subject);
  void FindSubject();
  void TakeBack(int view_id);
  void Finish();

  // As the state says, or as was asked since.
  bool Records(const CaptureState& state) const;
  std::optional<Subject> SubjectOf(const CaptureState& state) const;
  bool IsTakenBack(int view_id) const { return taken_back_.contains(view_id); }
  std::optional<int> LastView(const CaptureState& state) const;

  // Changes with every Record(): whoever paused can see whether somebody has wished otherwise since.
  std::uint64_t record_ticket() const { return record_.ticket; }

 private:
  template <typename Value>
  struct Wish {
    Value value{};
    std::uint64_t ticket = 0;  // of the request; 0: none yet
    bool IsOpen(const CaptureState& state) const { return ticket > state.requests_answered; }
  };
  CaptureRequests& requests_;
  Wish<bool> record_;
  Wish<std::optional<Subject>> subject_;
  std::set<int> taken_back_;  // no number is given twice
};

}  // namespace ulf::coverage
