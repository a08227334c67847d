// What a tethered camera still holds of a session when its link drops. The driver that was lost writes it
// down; the one that opens the same camera again fetches it. Shared by the two, which run in different
// threads.
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
  struct Left {
    std::vector<FileInCamera> waiting;    // announced, not downloaded
    std::optional<GphotoFile> last = {};  // that was announced; none: none was
    double released_s =
        0;  // when the shutter was asked to open for a photograph that was not announced; 0: none was
    double lost_s = 0;  // host clock
  };
  // The camera has announced the file.
  void Announced(const GphotoFile& file);
  // The link is gone. Where `left` does not say which file was the last, it is the one that was announced
  // last.
  void Lost(Left left);
  // Once for each loss; none: the link was not lost.
  std::optional<Left> Take();
  // Of the files that a folder of the camera holds now, the photographs that came after the last one that was
  // announced, by the numbers in their names, in their order.
  std::vector<GphotoFile> After(const Left& left, std::vector<std::string> names) const;
  // What is to be fetched of `files`, which came since. The first photograph among them answers the request
  // that was open.
  static std::vector<FileInCamera> CameSince(const Left& left, const std::vector<GphotoFile>& files);

  // A file on a card is fetched although the camera did not announce it.
  void Fetched(const GphotoFile& file);
  // Whether the file was fetched so, or announced before the link was lost: a camera may announce it once
  // more.
  bool WasFetched(const GphotoFile& file) const;

 private:
  mutable Mutex mutex_;
  std::set<std::string> announced_ ULF_GUARDED_BY(mutex_), fetched_
      ULF_GUARDED_BY(mutex_);  // folder and name
  std::optional<GphotoFile> last_ ULF_GUARDED_BY(mutex_);
  std::optional<Left> left_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::acquisition
