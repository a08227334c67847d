// Small pictures of the recorded views, as many as fit into a memory budget. The newest view's picture comes
// with the capture's state; others (of an earlier session, or dropped from memory) are read from the light
// field when they are needed. Ids and poses always come from the newest state.
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
  // Guessed.
  struct Options {
    std::size_t most_bytes = 64 << 20;  // some six hundred pictures of a scene rich in detail: most captures
    std::size_t most_drawn = 3;         // by Nearest(); more blur, fewer jump
    std::size_t most_fetched = 8;       // around a camera, ahead of its movement
    double least_share = 0.01;          // of the nearest one's weight; less is not worth drawing
  };
  RecordedPictures() : RecordedPictures(Options{}) {}
  explicit RecordedPictures(const Options& options) : options_(options) {}

  // Call for every new state: keeps the newest view's picture, drops those of views that were taken back.
  void Follow(const CaptureState& state);
  // The pictures nearest in direction to a camera, as seen from the subject, with weights that fall to 0 at
  // the first one left out. Pictures that are not in memory are skipped, and fetched for a later call. Valid
  // until the next call of any function.
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

  const Options options_;
  std::map<int, Held> held_;
  std::size_t bytes_ = 0, missing_ = 0;
  std::uint64_t clock_ = 0;
  int newest_ = 0;  // that was kept
  std::unique_ptr<StoredPictures> stored_;
};

}  // namespace ulf::coverage
