#include "tests/charts/temporal/truth.h"

#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/geometry/pinhole.h"
#include "core/image/files/exr_file.h"
#include "core/image/files/picture_file.h"
#include "core/image/image.h"
#include "render/quality/quality.h"
#include "tests/support/floors.h"

namespace ulf::test {
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

class SimulatedTruth : public TruthSource {
 public:
  explicit SimulatedTruth(const DeviceUri& uri)
      : name_(uri.Text()), camera_(SimulationOptions::FromUri(uri)) {}

  cv::Mat Picture(int /*index*/, const CameraModel& camera, const Rigid3& cam_from_world) override {
    return CasterOf(camera).Radiance(cam_from_world) * camera_.LightScale();
  }
  cv::Mat Depth(const CameraModel& camera, const Rigid3& cam_from_world) override {
    cv::Mat depth = CasterOf(camera).RayLength(cam_from_world);
    for (int y = 0; y < depth.rows; ++y)
      for (int x = 0; x < depth.cols; ++x)
        depth.at<float>(y, x) /= static_cast<float>(PinholeRay(camera, x, y).norm());
    return depth;
  }
  bool TakesAnyCamera() const override { return true; }

  // In the same world photographs differ from the truth only by noise and motion.
  void RequireSameWorld(const RenderScene& scene) override {
    constexpr double kLeastPsnrDb = 20;  // below it the photograph shows something else. Guessed.
    const SceneView& view = scene.views[scene.views.size() / 2];
    const cv::Mat truth = Srgb8FromLinear(Picture(0, view.camera, view.cam_from_world));
    const double psnr_db =
        CompareImages(truth, view.Srgb8(), cv::Mat(truth.size(), CV_8U, cv::Scalar(255))).psnr_db;
    if (psnr_db < kLeastPsnrDb)
      throw Error(
          "--truth {}: view {} does not look like this scene from its pose ({:.1f} dB); its poses may be "
          "tracked ones, in another world; give the URI that was captured, and poses in its world (ulf "
          "capture --poses known)",
          name_, view.id, psnr_db);
  }

 private:
  const RayCaster& CasterOf(const CameraModel& camera) {
    if (!caster_ || caster_->camera() != camera)
      caster_.emplace(Scene::Named(camera_.options().scene), camera);
    return *caster_;
  }

  std::string name_;
  SimulatedCamera camera_;
  std::optional<RayCaster> caster_;
};

}  // namespace

std::unique_ptr<TruthSource> TruthFromName(const std::string& name) {
  if (name.starts_with("sim:")) return std::make_unique<SimulatedTruth>(DeviceUri::Parse(name));
  if (!std::filesystem::is_directory(name))
    throw Error(
        "--truth {}: is neither a simulator (sim:studio?seed=7) nor a folder of pictures frame_00000.png",
        name);
  return std::make_unique<PicturesOfTruth>(name);
}

}  // namespace ulf::test
