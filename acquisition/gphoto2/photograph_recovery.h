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

// Returns the files' paths in the camera, joined for a message.
std::string NamesOf(const std::vector<FileInCamera>& files);

class PhotographRecovery {
 public:
  // `camera` and `left` must outlive this object. `gone`: whether a call failed because the camera is gone.
  PhotographRecovery(GphotoCamera& camera, UnfetchedPhotographs& left,
                     std::function<void(const std::string&)> notice,
                     std::function<bool(const GphotoResult&)> gone)
      : camera_(camera), left_(left), notice_(std::move(notice)), gone_(std::move(gone)) {}

  // Takes the list that the lost driver left. Call it first.
  void Begin() { to_fetch_ = left_.Take(); }
  struct Found {
    std::vector<FileInCamera> files;  // to be downloaded
    std::vector<GphotoFile> since;    // those of `files` that the camera did not announce
    std::size_t counted = 0;          // how many of `files` were waiting when the link dropped
  };
  // Returns the files once; none before, while a camera that was switched on is busy, and afterwards.
  std::optional<Found> Work();
  // Returns the list if Work() has not used it up, for the next driver.
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
