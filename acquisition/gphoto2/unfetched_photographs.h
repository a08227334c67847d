// Lists what a tethered camera still holds of a session when its link drops. The lost driver writes the list,
// the one that opens the same camera again fetches the files. The two share it and run in different threads.
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

// A file in the camera with the known facts of its photograph, without bytes.
using FileInCamera = std::pair<GphotoFile, DownloadedFile>;

class UnfetchedPhotographs {
 public:
  struct Unfetched {
    std::vector<FileInCamera> waiting;    // announced, not downloaded
    std::optional<GphotoFile> last = {};  // that was announced; none: none was
    double released_s =
        0;  // when the shutter was asked to open for a photograph that was not announced; 0: none was
    double lost_s = 0;  // host clock
  };
  // Notes a file that the camera has announced.
  void Announced(const GphotoFile& file);
  // Notes what is left when the link is gone. A missing `left.last` becomes the file that was announced last.
  void Lost(Unfetched left);
  // Returns once for each loss what is left; none: the link was not lost.
  std::optional<Unfetched> Take();
  // Returns, of the files that a folder of the camera holds now, the photographs that came after the last
  // announced one, by the numbers in their names, in their order.
  std::vector<GphotoFile> PhotographsAfter(const Unfetched& left, std::vector<std::string> names) const;
  // Returns what is to be fetched of `files`, which came since. The first photograph among them answers the
  // request that was open.
  static std::vector<FileInCamera> CameSince(const Unfetched& left, const std::vector<GphotoFile>& files);

  // Notes a file that is fetched from the card although the camera did not announce it.
  void Fetched(const GphotoFile& file);
  // Returns whether the file was fetched so, or announced before: a camera may announce it once more.
  bool WasFetched(const GphotoFile& file) const;

 private:
  mutable Mutex mutex_;
  std::set<std::string> announced_ ULF_GUARDED_BY(mutex_), fetched_
      ULF_GUARDED_BY(mutex_);  // folder and name
  std::optional<GphotoFile> last_ ULF_GUARDED_BY(mutex_);
  std::optional<Unfetched> left_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::acquisition
