// Small pictures of the recorded views, as many as a budget holds: the newest view's is at hand in the
// capture's state; every other one, of an earlier session or long not looked at, is read from the light field
// when it is wanted. Which views there are, and where they stand, is always the newest state's to say.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coverage/operator/posed_pictures.h"
#include "coverage/operator/stored_pictures.h"
#include "coverage/session/capture_state.h"

namespace ulf::coverage {

class RecordedPictures {
 public:
  // Some six hundred pictures of a scene rich in detail: what most captures come to.
  static constexpr std::size_t kMostBytes = 64 << 20;
  explicit RecordedPictures(std::size_t most_bytes = kMostBytes) : most_bytes_(most_bytes) {}

  // Every new state: the newest view's picture is kept, those of views that are no more go.
  void Follow(const CaptureState& state);
  // Those nearest in direction to a camera, as seen from the subject, with weights that fall to 0 at the
  // first one left out. Those that are not at hand are passed over, and fetched for a later time. Valid until
  // the next call of anything.
  std::vector<WeightedPicture> Nearest(const CaptureState& state, const Rigid3& cam_from_world);
  // Of the last Nearest(): being read.
  std::size_t missing() const { return missing_; }
  std::size_t bytes() const { return bytes_; }
  std::size_t size() const { return held_.size(); }
  // Why a picture is left out, once each.
  std::optional<std::string> TakeProblem();

 private:
  struct Held {
    PosedPicture picture;
    std::uint64_t used = 0;  // the last time, by clock_
  };
  void Hold(int id, PosedPicture picture);
  void MakeRoom();
  void DropTakenBack(const std::vector<int>& view_ids);
  void Fetch(const CaptureState& state, std::vector<int> ids);

  const std::size_t most_bytes_;
  std::map<int, Held> held_;
  std::size_t bytes_ = 0, missing_ = 0;
  std::uint64_t clock_ = 0;
  int newest_ = 0;  // that was kept
  std::unique_ptr<StoredPictures> stored_;
};

}  // namespace ulf::coverage
