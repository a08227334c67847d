// Downloads the files that a camera has announced. A failed download is repeated while the camera still has
// the file, with growing pauses in which live view continues. Files that are given up are named, so that the
// user can copy them from the card. Used by the thread that owns the camera.
#pragma once

#include <string>
#include <vector>

#include "acquisition/gphoto2/gphoto_camera.h"
#include "acquisition/gphoto2/photograph_pairing.h"

namespace ulf::acquisition {

class PhotographDownloads {
 public:
  explicit PhotographDownloads(GphotoCamera& camera) : camera_(camera) {}

  // Adds a file to download; `file`: name and times, without bytes. `now_s`: seconds by any steady clock.
  void Announced(const GphotoFile& where, DownloadedFile file, double now_s);

  struct Outcome {
    std::vector<std::pair<GphotoFile, DownloadedFile>> downloaded;  // with bytes
    std::vector<DownloadedFile> given_up;                           // without bytes
    std::vector<std::string> messages;                              // about failures, for the user
    GphotoResult failure;  // the last failure, by which the camera may be gone; ok(): there was none
  };
  // Tries the downloads that are due.
  Outcome Work(double now_s);

  std::size_t Count() const { return waiting_.size(); }  // files that wait
  bool Awaits(const std::string& stem) const;            // whether a file of this photograph waits
  // Returns all files that wait, and gives them up.
  std::vector<std::pair<GphotoFile, DownloadedFile>> GiveUpAll();

 private:
  struct Waiting {
    GphotoFile where;
    DownloadedFile file;
    double announced_s = 0, again_s = 0;  // of now_s
    double busy_pause_s = 0;              // the last one; doubled each time
    int failures = 0;
  };
  // Returns whether the file is given up after this failure.
  bool GivesUp(const GphotoResult& result, double now_s, Waiting& waiting, Outcome& outcome);

  GphotoCamera& camera_;
  std::vector<Waiting> waiting_;
};

}  // namespace ulf::acquisition
