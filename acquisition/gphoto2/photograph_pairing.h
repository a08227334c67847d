// From files, as a camera announces them, to photographs: a JPEG and the raw file beside it share a stem and
// may come in either order, seconds apart. Files and times in, photographs out.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace ulf {

struct DownloadedFile {
  std::string name;  // as in the camera
  std::string bytes;
  double announced_s = 0;  // host clock
  double released_s = 0;   // when the shutter was asked to open; 0: on the body
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

class GphotoCamera;

// The image formats that the camera offers and that come with a JPEG, for people.
std::string FormatsWithJpeg(GphotoCamera& camera);

class PhotographPairing {
 public:
  // `patience_s`: how long one half waits for the other.
  explicit PhotographPairing(double patience_s) : patience_s_(patience_s) {}

  // Whether a JPEG is to wait for a raw file, and a raw file for a JPEG: what the camera's format setting
  // says. Without a word about it a JPEG waits for nothing and a raw file waits.
  void ExpectFormat(const std::string& image_format);
  bool ExpectsJpeg() const { return expects_jpeg_; }

  void Add(DownloadedFile file, double now_s);
  // Those that are complete, or have waited long enough; all with `all`.
  std::vector<DownloadedPhotograph> Take(double now_s, bool all = false);

 private:
  struct Waiting {
    DownloadedPhotograph photograph;
    double since_s = 0;
  };
  bool IsComplete(const DownloadedPhotograph& photograph) const;

  double patience_s_;
  bool expects_raw_ = false, expects_jpeg_ = true;
  std::map<std::string, Waiting> waiting_;  // by folder-less stem
  std::vector<DownloadedPhotograph> ready_;
};

}  // namespace ulf
