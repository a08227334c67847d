// Stores depth maps that several processes make, each of a share of a light field's views, and another fuses
// (proxy_builder.h), on one disk. A folder holds each map as a TIFF of 32-bit floats, and for each share an
// index, written last: a share is present as a whole or not at all, and a repeated one replaces itself.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <string>

namespace ulf::render {

struct SweptMap {
  cv::Mat depth;          // CV_32F, along the optical axis in world units; 0: none
  double plane_step = 0;  // inverse depth between planes of the sweep
};
using SweptMaps = std::map<int, SweptMap>;  // by View::id

// A share is every `of`-th of the views that get a depth map, from number `index` (from 0) on.
struct MapShare {
  static constexpr int kMost = 60000;  // shares, as depth maps at most
  int index = 0, of = 1;
  bool IsValid() const { return of >= 1 && of <= kMost && index >= 0 && index < of; }
  // Parses "K/N"; throws Refusal.
  static MapShare Parse(const std::string& text);
};

// `digest` covers all that the maps depend on (SweepDigest()). Throws DiskFullError, Error.
void WriteSweptMaps(const std::filesystem::path& folder, const MapShare& share, std::uint64_t digest,
                    const SweptMaps& maps);

// The maps of all shares of a folder, as their indices name them; each is read on demand.
class SweptMapFiles {
 public:
  // Reads the map of View::id `id`. Throws Error if it is missing, not of `size`, or its bytes have changed.
  SweptMap Read(int id, const cv::Size& size) const;

 private:
  friend SweptMapFiles FindSweptMaps(const std::filesystem::path& folder, std::uint64_t digest);
  struct File {
    std::string name, checksum;
    double plane_step = 0;
  };
  explicit SweptMapFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
  std::map<int, File> files_;  // by View::id
};

// Throws Error that names missing shares, and for one that was made of other photographs, masks, cameras,
// poses or options.
SweptMapFiles FindSweptMaps(const std::filesystem::path& folder, std::uint64_t digest);

}  // namespace ulf::render
