// A view of the scene lightbox with other exposures, taken one after another while the simulated hand moves
// on, as `ulf capture --bracket` leaves it; poses are exact. And what a merge of it is measured against.
#pragma once

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/simulator/simulated_camera.h"
#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "core/light_field/light_field.h"
#include "render/proxy/points_proxy.h"
#include "tests/support/floors.h"

namespace ulf::test {

struct BracketedView {
  unsigned seed = 7;
  int width = 240, height = 180;
  double exposure_s = 0.001;  // of the view; a light of 0.2 is full scale
  double between_s = 0.1;     // from one exposure to the next
  double at_s = 1;            // of the hand's motion
  std::string scene = "lightbox";
  double speed_deg_s = 5;  // 0: on a stand
};

class Stand : public HandMotion {
 public:
  explicit Stand(const Rigid3& cam_from_world) : cam_from_world_(cam_from_world) {}
  Rigid3 CamFromWorld(double) const override { return cam_from_world_; }

 private:
  Rigid3 cam_from_world_;
};

inline SimulatedCamera LightboxCamera(const BracketedView& view) {
  const SimulatedCamera in_hand(SimulationOptions::FromUri(DeviceUri::Parse(
      "sim:" + view.scene + "?format=bayerrg12&look_away=0&seed=" + std::to_string(view.seed) +
      "&speed_deg_s=" + std::to_string(view.speed_deg_s > 0 ? view.speed_deg_s : 5) +
      "&width=" + std::to_string(view.width) + "&height=" + std::to_string(view.height) +
      "&exposure_us=" + std::to_string(1e6 * view.exposure_s))));
  if (view.speed_deg_s > 0) return SimulatedCamera(in_hand.options());
  return SimulatedCamera(in_hand.options(), std::make_shared<Stand>(in_hand.hand().CamFromWorld(view.at_s)));
}

// One view with exposures so many stops from its own. `camera`: of LightboxCamera().
inline LightField TakeBracket(const SimulatedCamera& camera, const BracketedView& how,
                              const std::filesystem::path& dir, const std::vector<double>& stops) {
  const auto take = [&](std::size_t number, double off_stops) {
    return camera.Capture(Shot{.open_s = how.at_s + how.between_s * static_cast<double>(number),
                               .exposure_s = how.exposure_s * std::exp2(off_stops),
                               .gain = 1,
                               .format = SensorFormat::kBayerRg12,
                               .id = number + 1});
  };
  CaptureHeader header;
  header.camera = camera.camera();
  LightFieldWriter writer = LightFieldWriter::Create(dir, header);
  const Frame own = take(0, 0);
  View view;
  view.cam_from_world = *own.known_cam_from_world;
  writer.AddView(own, view);
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const Frame frame = take(i + 1, stops[i]);
    writer.AddExposure(1, frame, *frame.known_cam_from_world * view.cam_from_world.Inverse(), false);
  }
  writer.SetSubject(camera.scene().subject());
  writer.Close(1);
  return ReadLightField(dir);
}

// Of green, by whole stops of the true light (0: up from full scale of the view's own exposure):
// shares of the light.
using ErrorsByStop = std::map<int, std::vector<double>>;

inline void AddErrors(const cv::Mat& light, const cv::Mat& truth, ErrorsByStop& errors) {
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x) {
      const double is = light.at<cv::Vec3f>(y, x)[1], should = truth.at<cv::Vec3f>(y, x)[1];
      if (should > 0)
        errors[static_cast<int>(std::floor(std::log2(should)))].push_back(std::abs(is / should - 1));
    }
}

// Of one exposure by itself (0: the view's own), against what is to be seen where it was taken.
inline void AddErrorsAlone(const SimulatedCamera& camera, const LightField& light_field, const View& view,
                           std::size_t number, ErrorsByStop& errors) {
  const View alone = number == 0 ? view : PhotographOf(view, view.exposures.at(number - 1));
  const cv::Mat light = LinearFloat(ReadViewMaster(light_field, alone)) - cv::Scalar::all(alone.black_level);
  AddErrors(light * (view.exposure_s / alone.exposure_s), camera.CleanLinear(alone.cam_from_world), errors);
}

// Points of what the camera sees from there, as a tracker has them but exact.
inline std::shared_ptr<const Proxy> PointsSeen(const SimulatedCamera& camera, const Rigid3& cam_from_world,
                                               int count) {
  std::vector<ScenePoint> points;
  cv::RNG random(17);
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  while (static_cast<int>(points.size()) < count) {
    const auto ray = camera.camera().RayFromImg({random.uniform(-0.1, 1.1) * camera.camera().width,
                                                 random.uniform(-0.1, 1.1) * camera.camera().height});
    if (!ray) continue;
    const Eigen::Vector3d direction = (world_from_cam.rotation * *ray).normalized();
    ScenePoint point;
    point.position_in_world = world_from_cam.translation +
                              camera.scene().DepthAlong(world_from_cam.translation, direction) * direction;
    points.push_back(point);
  }
  return std::make_shared<PointsProxy>(camera.scene().subject(), points);
}

}  // namespace ulf::test
