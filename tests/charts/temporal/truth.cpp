#include "tests/charts/temporal/truth.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/base/error.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"

namespace ulf::render {
namespace {

namespace fs = std::filesystem;

class PicturesOfTruth : public TruthSource {
 public:
  explicit PicturesOfTruth(fs::path folder) : folder_(std::move(folder)) {}

  cv::Mat Picture(int index, const CameraModel& camera, const Rigid3& /*cam_from_world*/) override {
    const fs::path stem = folder_ / fmt::format("frame_{:05}", index);
    const fs::path png = fs::path(stem).concat(".png"), exr = fs::path(stem).concat(".exr");
    if (!fs::exists(png) && !fs::exists(exr))
      throw Error("--truth {}: there is neither {} nor {}; give every picture of the path", folder_.string(),
                  png.filename().string(), exr.filename().string());
    const cv::Mat linear =
        fs::exists(exr) ? ReadExr(exr.string()) : LinearFloat({.pixels = ReadImageFile(png.string())});
    if (linear.cols != camera.width || linear.rows != camera.height)
      throw Error("--truth {}: picture {} has {}x{} pixels, the path's camera {}x{}", folder_.string(), index,
                  linear.cols, linear.rows, camera.width, camera.height);
    return linear;
  }
  bool TakesAnyCamera() const override { return false; }
  void RequireSameWorld(const RenderScene& /*scene*/) override {}

 private:
  fs::path folder_;
};

}  // namespace

std::unique_ptr<TruthSource> TruthFromFolder(const std::string& folder) {
  return std::make_unique<PicturesOfTruth>(folder);
}

}  // namespace ulf::render
