// Files that a camera has announced, until they are here. One that fails is tried again while the camera
// still holds it, with growing pauses in which live view goes on; what is given up is named, so that it can
// be fetched from the card by hand. Belongs to the thread that owns the camera.
#pragma once

#include <string>
#include <vector>

#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/photograph_pairing.h"

namespace ulf::acquisition {

class PhotographDownloads {
 public:
  explicit PhotographDownloads(GphotoCamera& camera) : camera_(camera) {}

  // `file`: its name and times.
  void Announced(const GphotoFile& where, DownloadedFile file, double now_s);

  struct Outcome {
    std::vector<std::pair<GphotoFile, DownloadedFile>> here;  // with its bytes
    std::vector<DownloadedFile> given_up;                     // without
    std::vector<std::string> words;                           // for people: what failed, what was given up
    GphotoResult failure;  // of the last attempt that failed; the camera may be gone
  };
  // Tries what is due.
  Outcome Work(double now_s);

  std::size_t Count() const { return waiting_.size(); }  // that wait
  bool Awaits(const std::string& stem) const;            // a file of this photograph
  // The camera is gone, or time is up: gives up what waits. For people; empty: nothing waits.
  std::string GiveUpAll();

 private:
  struct Waiting {
    GphotoFile where;
    DownloadedFile file;
    double announced_s = 0, again_s = 0;  // of now_s
    int failures = 0;
  };
  void Failed(const GphotoResult& result, double now_s, Waiting& waiting, bool& given_up, Outcome& outcome);

  GphotoCamera& camera_;
  std::vector<Waiting> waiting_;
};

}  // namespace ulf::acquisition
