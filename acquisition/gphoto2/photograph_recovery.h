// Fetches what a tethered camera kept on its card when its link dropped, and what it took until it was opened
// again (unfetched_photographs.h says which files those are). Used by the thread that owns the camera.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/unfetched_photographs.h"

namespace ulf::acquisition {

// Returns the files' paths in the camera, for a message.
std::string NamesOf(const std::vector<FileInCamera>& files);

class PhotographRecovery {
 public:
  // `camera` and `left` outlive it. `gone`: whether a call failed because the camera is gone.
  PhotographRecovery(GphotoCamera& camera, UnfetchedPhotographs& left,
                     std::function<void(const std::string&)> notice,
                     std::function<bool(const GphotoResult&)> gone)
      : camera_(camera), left_(left), notice_(std::move(notice)), gone_(std::move(gone)) {}

  void Begin() { to_fetch_ = left_.Take(); }
  // The files to be downloaded. Work() returns them once, none while there are none yet: a camera that is
  // busy, as after it was switched on, is asked again.
  struct Found {
    std::vector<FileInCamera> files;
    std::vector<GphotoFile> since;  // of these, those that the camera did not announce
    std::size_t counted = 0;        // of these, those that were waiting when the link dropped
  };
  std::optional<Found> Work();
  // Returns what has not been looked for so far.
  std::optional<UnfetchedPhotographs::Unfetched> TakeUnfetched() {
    return std::exchange(to_fetch_, std::nullopt);
  }

 private:
  bool LeaveOlder(std::vector<GphotoFile>& files);

  GphotoCamera& camera_;
  UnfetchedPhotographs& left_;
  const std::function<void(const std::string&)> notice_;
  const std::function<bool(const GphotoResult&)> gone_;
  std::optional<UnfetchedPhotographs::Unfetched> to_fetch_;
  int busy_listings_ = 0;
};

}  // namespace ulf::acquisition
