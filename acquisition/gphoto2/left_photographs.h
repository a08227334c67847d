// What a tethered camera still holds of a session when its link drops. The driver that was lost writes it down; the one
// that opens the same camera again fetches it. Shared by the two, which run in different threads.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/photograph_pairing.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {

// A file in the camera, with what is known of its photograph, without bytes.
using FileInCamera = std::pair<GphotoFile, DownloadedFile>;

class LeftPhotographs {
 public:
  // The camera has announced the file.
  void Announced(const GphotoFile& file);
  // The link is gone. `waiting`: announced, not downloaded. `released_s`: when the shutter was asked to open for a
  // photograph that has not been announced; 0: none was.
  void Lost(std::vector<FileInCamera> waiting, double released_s, double now_s);

  struct Left {
    std::vector<FileInCamera> waiting;
    std::optional<GphotoFile> last;  // that was announced; none: none was
    double released_s = 0;
    double lost_s = 0;
  };
  // Once for each loss; none: the link was not lost.
  std::optional<Left> Take();
  // Of the files that a folder of the camera holds now, those that came after the last one that was announced, by the
  // numbers in their names. The first photograph among them answers the request that was open.
  std::vector<FileInCamera> CameSince(const Left& left, std::vector<std::string> names) const;

 private:
  mutable Mutex mutex_;
  std::set<std::string> announced_ ULF_GUARDED_BY(mutex_);  // folder and name
  std::optional<GphotoFile> last_ ULF_GUARDED_BY(mutex_);
  std::optional<Left> left_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::acquisition
