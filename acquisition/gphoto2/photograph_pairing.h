// From files, as a camera announces them, to photographs: a JPEG and the raw file beside it share a stem and
// may come in either order, seconds apart. Files and times in, photographs out.
//
// A half whose other half is known to be on its way waits for it however long that takes. A half that comes
// when the other has been handed out already keeps the photograph's times but answers no request: one request
// has one answer.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ulf::acquisition {

struct DownloadedFile {
  std::string name;  // as in the camera
  std::string bytes;
  double announced_s = 0;  // host clock
  double released_s = 0;   // when the shutter was asked to open; 0: on the body
  bool is_late = false;    // the other half of a photograph that has been handed out
};

struct DownloadedPhotograph {
  DownloadedFile jpeg;  // without bytes when the camera made a raw file only
  DownloadedFile raw;   // without bytes when there is none
  const DownloadedFile& First() const { return jpeg.bytes.empty() ? raw : jpeg; }
};

// The name without its ending, in lower case: the same for a JPEG and its raw file.
std::string StemOf(const std::string& file_name);
// ".jpg" for every spelling of JPEG's.
std::string ExtensionOf(const std::string& file_name);

// Whether photographs in this image format, in a camera's own words, come with a JPEG.
bool ComesWithJpeg(const std::string& image_format);

class PhotographPairing {
 public:
  // `patience_s`: how long one half waits for the other.
  explicit PhotographPairing(double patience_s) : patience_s_(patience_s) {}

  // Whether a JPEG is to wait for a raw file, and a raw file for a JPEG: what the camera's format setting
  // says. Without a word about it a JPEG waits for nothing and a raw file waits.
  void ExpectFormat(const std::string& image_format);

  // Before its download: the times of the photograph that was handed out without this file; none: there was
  // none of the kind in the last minute.
  std::optional<DownloadedFile> LateHalf(const std::string& file_name, double now_s) const;
  void Add(DownloadedFile file, double now_s);
  bool Holds(const std::string& stem) const { return waiting_.contains(stem); }

  // By stem: whether a file is still on its way.
  using OnItsWay = std::function<bool(const std::string&)>;
  // Those that are complete, or have waited long enough.
  std::vector<DownloadedPhotograph> Take(
      double now_s, const OnItsWay& on_its_way = [](const std::string&) { return false; });
  // At the end: everything.
  std::vector<DownloadedPhotograph> TakeAll();

 private:
  struct Waiting {
    DownloadedPhotograph photograph;
    double since_s = 0;
  };
  struct HandedOut {
    DownloadedFile times;  // of its one half
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

}  // namespace ulf::acquisition
