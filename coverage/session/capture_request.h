// Requests to a running capture, by a key of the operator display, a line of text, or a test. The session
// answers them between two frames, in order, and reports the result of each.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/file_descriptor.h"
#include "core/base/mutex.h"
#include "core/light_field/light_field.h"

namespace ulf::coverage {

// Takes views out of the light field: their photographs go to unposed/, the coverage map is painted without
// them.
struct TakeBackLast {
  int count = 1;
};
struct TakeBackViews {
  std::vector<int> ids;
};
struct PlaceSphere {
  Subject subject;
};
// Places the subject's sphere around what is in the middle of the picture, so wide that its image takes
// `width_share` of the picture's width.
struct FindSubject {
  std::optional<double> depth;  // along the optical axis, world units; none: that of the tracked points there
  std::optional<double> width_share;  // none: CaptureOptions::subject_size
};
// Places the sphere that geometry proposes (subject_proposal.h).
struct PlaceProposedSphere {};
struct SetRecording {
  bool on = true;                     // off: tracked and shown, but not recorded
  bool although_checks_fail = false;  // only where the capture has not begun yet
};
struct FinishCapture {};

using CaptureRequest = std::variant<TakeBackLast, TakeBackViews, PlaceSphere, FindSubject,
                                    PlaceProposedSphere, SetRecording, FinishCapture>;

// Parses a line: "take-back", "take-back 3", "take-back views 17 18", "subject 0,0,1,0.2" (centre and
// radius), "subject", "subject depth 0.9 size 0.3", "subject proposed", "pause", "record", "record anyway",
// "finish". Throws Refusal that lists these.
CaptureRequest ParseCaptureRequest(const std::string& line);

// Hands requests from the threads that ask to the session's thread.
class CaptureRequests {
 public:
  // Returns the number of requests so far, this one included: once CaptureState::requests_answered is as
  // large, the request is answered.
  std::uint64_t Push(CaptureRequest request);
  std::vector<CaptureRequest> Take();  // for the session: all since the last call, in order

 private:
  Mutex mutex_;
  std::vector<CaptureRequest> asked_ ULF_GUARDED_BY(mutex_);
  std::uint64_t count_ ULF_GUARDED_BY(mutex_) = 0;
};

// Reads requests as lines of text from standard input or a file, typically a fifo, so that a script or
// another program can control a capture. Never blocks.
class RequestLines {
 public:
  // `path`: "-" is standard input. Throws Refusal when it cannot be read. `take` gets each line and throws
  // Refusal, in words, for one that is no request.
  RequestLines(const std::string& path, std::function<void(const std::string&)> take);

  // Hands over the complete lines that have arrived; reports the error of a refused one to `say`.
  void Take(const std::function<void(const std::string&)>& say);

 private:
  bool ReadMore();

  FileDescriptor descriptor_;
  bool others_may_write_ = false;  // a fifo: its end is only the end of the last writer
  std::string text_;
  std::function<void(const std::string&)> take_;
};

}  // namespace ulf::coverage
