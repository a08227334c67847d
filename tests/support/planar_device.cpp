#include "tests/support/planar_device.h"
#include "tests/support/floors.h"

#include <Eigen/LU>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

namespace ulf::test {
namespace {

constexpr int kPatternPx = 1024;
constexpr double kPatternSize = 4;  // world units, centred at the origin

cv::Mat DrawPattern() {
  cv::RNG random(20120101);
  cv::Mat fine(kPatternPx, kPatternPx, CV_8UC3), coarse(kPatternPx / 16, kPatternPx / 16, CV_8UC3), large;
  random.fill(fine, cv::RNG::UNIFORM, 40, 216);
  random.fill(coarse, cv::RNG::UNIFORM, 40, 216);
  cv::GaussianBlur(fine, fine, {5, 5}, 0);
  cv::resize(coarse, large, fine.size(), 0, 0, cv::INTER_NEAREST);
  return 0.4 * fine + 0.6 * large;
}

// The same for all devices of a program.
const cv::Mat& Pattern() {
  static const cv::Mat pattern = DrawPattern();
  return pattern;
}

}  // namespace

PlanarDevice::PlanarDevice(std::vector<PlanarShot> shots, const PlanarDeviceOptions& options)
    : shots_(std::move(shots)), options_(options), pattern_(Pattern()) {}

DeviceInfo PlanarDevice::Info() const {
  return {.uri = "planar:", .maker = "test", .model = "plane", .serial = "0", .bus = "test", .problem = {}};
}

DeviceState PlanarDevice::State() const {
  if (next_ < shots_.size()) return DeviceState::kStreaming;
  return options_.lost_at_end ? DeviceState::kLost : DeviceState::kEnded;
}

cv::Mat PlanarDevice::Render(const PlanarShot& shot) const {
  const CameraModel& camera = options_.camera;
  cv::Mat image(camera.height, camera.width, CV_8UC3,
                cv::Scalar::all(shot.fault == Fault::kOverexposed ? 255 : 0));
  if (shot.fault == Fault::kOverexposed || shot.fault == Fault::kBlack) return image;
  Eigen::Matrix3d img_from_cam = Eigen::Matrix3d::Identity();
  img_from_cam(0, 0) = camera.fx, img_from_cam(1, 1) = camera.fy;
  img_from_cam(0, 2) = camera.cx - 0.5, img_from_cam(1, 2) = camera.cy - 0.5;  // OpenCV's pixel centres
  Eigen::Matrix3d cam_from_plane;
  cam_from_plane.col(0) = shot.cam_from_world.RotationMatrix().col(0);
  cam_from_plane.col(1) = shot.cam_from_world.RotationMatrix().col(1);
  cam_from_plane.col(2) = shot.cam_from_world.translation;
  Eigen::Matrix3d plane_from_pattern = Eigen::Matrix3d::Identity();
  plane_from_pattern(0, 0) = plane_from_pattern(1, 1) = kPatternSize / kPatternPx;
  plane_from_pattern(0, 2) = plane_from_pattern(1, 2) = -0.5 * kPatternSize;
  cv::Mat img_from_pattern;
  cv::eigen2cv(Eigen::Matrix3d(img_from_cam * cam_from_plane * plane_from_pattern), img_from_pattern);
  cv::warpPerspective(pattern_, image, img_from_pattern, image.size(), cv::INTER_AREA, cv::BORDER_CONSTANT,
                      cv::Scalar::all(128));
  if (shot.fault == Fault::kBlurred) cv::GaussianBlur(image, image, {}, 4);
  return image;
}

std::optional<Frame> PlanarDevice::Next(std::chrono::milliseconds /*timeout*/) {
  if (!started_ || next_ >= shots_.size()) return std::nullopt;
  const PlanarShot& shot = shots_[next_];
  Frame frame;
  frame.image.pixels = Render(shot);
  frame.id = next_;
  frame.device_time_s = static_cast<double>(next_) / options_.fps;
  frame.host_time_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  frame.exposure_s = options_.exposure_s;
  if (shot.fault != Fault::kNoPose) frame.known_cam_from_world = shot.cam_from_world;
  if (shot.fault == Fault::kIncomplete) frame.status = FrameStatus::kIncomplete;
  ++(shot.fault == Fault::kIncomplete ? statistics_.incomplete : statistics_.delivered);
  ++next_;
  return frame;
}

}  // namespace ulf::test
