// Pairs downloaded files: a JPEG and its raw file share a stem and arrive in either order, seconds apart.
//
// A file whose partner is known to be on its way waits for it without limit. A file that arrives after its
// partner was delivered keeps the photograph's times but answers no request: each request has one answer.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/gphoto2/camera_settings.h"
#include "core/frames/frame.h"
#include "core/image/files/exif.h"

namespace ulf::acquisition {

struct DownloadedFile {
  std::string name;  // in the camera
  std::string bytes;
  double announced_s = 0;  // host clock, since the epoch
  double released_s = 0;   // when the program released the shutter, host clock; 0: released on the body
  bool is_late = false;    // its partner was delivered before
};

struct DownloadedPhotograph {
  DownloadedFile jpeg;  // without bytes when the camera made a raw file only
  DownloadedFile raw;   // without bytes when there is none
  const DownloadedFile& First() const { return jpeg.bytes.empty() ? raw : jpeg; }
};

// Returns the name without its ending, in lower case: the same for a JPEG and its raw file.
std::string StemOf(const std::string& file_name);
// Returns the ending in lower case; ".jpg" for every spelling of JPEG.
std::string ExtensionOf(const std::string& file_name);

class PhotographPairing {
 public:
  // `patience_s`: how long a file waits for a partner that is not known to be on its way.
  explicit PhotographPairing(double patience_s) : patience_s_(patience_s) {}

  // Tells from the camera's format setting whether a JPEG waits for a raw file, and a raw file for a JPEG.
  // Without this call only raw files wait.
  void ExpectFormat(const std::string& image_format);

  // Call it before a download: returns name and times of a file whose partner was delivered in the last
  // minute, else none.
  std::optional<DownloadedFile> LateFile(const std::string& file_name, double now_s) const;
  void Add(DownloadedFile file, double now_s);
  bool Holds(const std::string& stem) const { return waiting_.contains(stem); }

  // Whether a file with this stem is still to be downloaded.
  using OnItsWay = std::function<bool(const std::string&)>;
  // Returns the photographs that are complete or have waited long enough.
  std::vector<DownloadedPhotograph> Take(
      double now_s, const OnItsWay& on_its_way = [](const std::string&) { return false; });
  // Returns all photographs, complete or not.
  std::vector<DownloadedPhotograph> TakeAll();

 private:
  struct Waiting {
    DownloadedPhotograph photograph;
    double since_s = 0;
  };
  struct HandedOut {
    DownloadedFile times;  // of the delivered file
    bool was_jpeg = false;
    double at_s = 0;
  };
  bool IsComplete(const DownloadedPhotograph& photograph) const;

  double patience_s_;
  bool expects_raw_ = false, expects_jpeg_ = true;
  std::map<std::string, Waiting> waiting_;       // by folder-less stem
  std::map<std::string, HandedOut> incomplete_;  // of the last minute, by stem
  std::vector<DownloadedPhotograph> ready_;
};

// Makes a frame of a downloaded photograph; its pixels stay encoded. Exposure and gain come from `exif`, else
// from the camera's settings. The time is that of the release plus the lag, or that of the announcement for a
// photograph released on the body. The caller sets Frame::id and host_time_s.
Frame FrameOf(DownloadedPhotograph photograph, const ExifFacts& exif, const CameraSettings& settings,
              double shutter_lag_s);

}  // namespace ulf::acquisition
