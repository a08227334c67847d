// Lists the files of a session that a tethered camera still holds when its link drops. The driver that loses
// the link writes the list; the driver that opens the same camera again takes it and fetches the files. The
// two share it: several threads may call all functions.
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

// A file in the camera, and what is known of it before the download: all but DownloadedFile::bytes.
using FileInCamera = std::pair<GphotoFile, DownloadedFile>;

class UnfetchedPhotographs {
 public:
  struct Unfetched {
    std::vector<FileInCamera> waiting;    // announced, not downloaded
    std::optional<GphotoFile> last = {};  // the file that was announced last; none: no file was
    // When the program released the shutter for a photograph that was not announced; 0: all were.
    double released_s = 0;  // host clock
    double lost_s = 0;      // when the link dropped, host clock
  };
  // Notes a file that the camera has announced.
  void Announced(const GphotoFile& file);
  // Notes what is left when the link is gone. If `left.last` is none, it becomes the file noted last.
  void Lost(Unfetched left);
  // Returns what the last Lost() noted, once; none if the link was not lost since.
  std::optional<Unfetched> Take();
  // `names`: the files that the folder of `left.last` holds now. Returns the JPEG and raw files among them
  // that were not announced and do not come before `left.last` (one may be its other file), ordered by the
  // numbers in their names; empty without `left.last`.
  std::vector<GphotoFile> PhotographsAfter(const Unfetched& left, std::vector<std::string> names) const;
  // Returns `files`, the result of PhotographsAfter(), with what is known of each; empty without `left.last`.
  // The first photograph after `left.last` answers the open request (`left.released_s`).
  static std::vector<FileInCamera> CameSince(const Unfetched& left, const std::vector<GphotoFile>& files);

  // Notes a file that is fetched from the card although the camera did not announce it.
  void Fetched(const GphotoFile& file);
  // Returns whether Fetched() noted the file, or Announced() before the last loss: it may be announced again.
  bool WasFetched(const GphotoFile& file) const;

 private:
  mutable Mutex mutex_;
  std::set<std::string> announced_ ULF_GUARDED_BY(mutex_), fetched_
      ULF_GUARDED_BY(mutex_);  // folder and name
  std::optional<GphotoFile> last_ ULF_GUARDED_BY(mutex_);
  std::optional<Unfetched> left_ ULF_GUARDED_BY(mutex_);
};

}  // namespace ulf::acquisition
