#include "tests/charts/temporal/simulated_truth.h"

#include <filesystem>
#include <optional>

#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/geometry/pinhole.h"
#include "core/image/image.h"
#include "render/quality/quality.h"

namespace ulf::commands {
namespace {

class SimulatedTruth : public render::TruthSource {
 public:
  explicit SimulatedTruth(const DeviceUri& uri)
      : name_(uri.Text()), camera_(acquisition::SimulationOptions::FromUri(uri)) {}

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
  void RequireSameWorld(const render::RenderScene& scene) override {
    constexpr double kLeastPsnrDb = 20;  // below it the photograph shows something else. Guessed.
    const render::SceneView& view = scene.views[scene.views.size() / 2];
    const cv::Mat truth = Srgb8FromLinear(Picture(0, view.camera, view.cam_from_world));
    const double psnr_db =
        render::CompareImages(truth, view.Srgb8(), cv::Mat(truth.size(), CV_8U, cv::Scalar(255))).psnr_db;
    if (psnr_db < kLeastPsnrDb)
      throw Error(
          "--truth {}: view {} does not look like this scene from its pose ({:.1f} dB); its poses may be "
          "tracked ones, in another world; give the URI that was captured, and poses in its world (ulf "
          "capture --poses known)",
          name_, view.id, psnr_db);
  }

 private:
  const acquisition::RayCaster& CasterOf(const CameraModel& camera) {
    if (!caster_ || caster_->camera() != camera)
      caster_.emplace(acquisition::Scene::Named(camera_.options().scene), camera);
    return *caster_;
  }

  std::string name_;
  acquisition::SimulatedCamera camera_;
  std::optional<acquisition::RayCaster> caster_;
};

}  // namespace

std::unique_ptr<render::TruthSource> TruthFromName(const std::string& name) {
  if (name.starts_with("sim:")) return std::make_unique<SimulatedTruth>(DeviceUri::Parse(name));
  if (!std::filesystem::is_directory(name))
    throw UsageError(
        "--truth {}: is neither a simulator (sim:studio?seed=7) nor a folder of pictures frame_00000.png",
        name);
  return render::TruthFromFolder(name);
}

}  // namespace ulf::commands
