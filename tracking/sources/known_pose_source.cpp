#include "tracking/sources/pose_sources.h"

#include <algorithm>
#include <deque>
#include <opencv2/imgproc.hpp>

#include "core/base/quantile.h"

namespace ulf::tracking {
namespace {

constexpr int kDetailWidth = 480;    // px, of the image that sharpness is measured on. Guessed
constexpr std::size_t kRecent = 30;  // frames that sharpness is relative to. Guessed

// Returns the mean squared Laplacian of a lightly smoothed, small image, relative to its contrast.
double Detail(const Image& image) {
  cv::Mat gray = GrayForTracking(image), small, laplacian;
  const double scale = std::min(1.0, static_cast<double>(kDetailWidth) / gray.cols);
  cv::resize(gray, small, {}, scale, scale, cv::INTER_AREA);
  cv::GaussianBlur(small, small, {3, 3}, 0);
  cv::Laplacian(small, laplacian, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(small, mean, deviation);
  return cv::norm(laplacian, cv::NORM_L2SQR) / static_cast<double>(laplacian.total()) /
         (1 + deviation[0] * deviation[0]);
}

class KnownPoseSource : public PoseSource {
 public:
  KnownPoseSource(const CameraModel& camera, const std::optional<Subject>& subject, bool metric)
      : camera_(camera), subject_(subject), metric_(metric) {}

  Track Step(const Frame& frame) override {
    Track track;
    track.state = TrackState::kLost;
    track.skipped = frame.status != FrameStatus::kComplete || frame.image.empty();
    if (track.skipped || !frame.known_cam_from_world) {
      last_pose_.reset();
      return track;
    }
    track = TrackOf(*frame.known_cam_from_world);
    track.sharpness = SharpnessAgainstRecent(frame.image);
    if (last_pose_) track.speed_px = MotionPx(*last_pose_, *frame.known_cam_from_world);
    last_pose_ = frame.known_cam_from_world;
    return track;
  }
  std::optional<Track> Locate(const Frame& photograph, const CameraModel& /*camera*/,
                              const std::optional<Rigid3>& /*near*/) const override {
    if (!photograph.known_cam_from_world) return std::nullopt;
    return TrackOf(*photograph.known_cam_from_world);
  }
  Rigid3 PoseOf(const Anchored& anchor) const override { return anchor.cam_from_keyframe; }
  bool IsMetric() const override { return metric_; }

 private:
  static Track TrackOf(const Rigid3& cam_from_world) {
    Track track;
    track.state = TrackState::kTracking;
    track.cam_from_world = cam_from_world;
    track.anchor = Anchored{0, cam_from_world};
    track.quality = 1;
    return track;
  }

  double SharpnessAgainstRecent(const Image& image) {
    const double detail = Detail(image);
    recent_detail_.push_back(detail);
    if (recent_detail_.size() > kRecent) recent_detail_.pop_front();
    const double usual = Median({recent_detail_.begin(), recent_detail_.end()});
    return usual > 0 ? detail / usual : 1;
  }

  // Returns how far the image moves at the subject's distance: the median over a grid of pixels.
  double MotionPx(const Rigid3& before, const Rigid3& now) const {
    if (!subject_) return 0;
    const double distance = (before * subject_->center_in_world).norm();
    std::vector<double> motions;
    for (int i = 1; i <= 3; ++i)
      for (int j = 1; j <= 3; ++j) {
        const Eigen::Vector2d img(0.25 * i * camera_.width, 0.25 * j * camera_.height);
        const auto ray = camera_.RayFromImg(img);
        if (!ray) continue;
        const auto moved = camera_.ImgFromCam(now * (before.Inverse() * (distance * *ray)));
        if (moved) motions.push_back((*moved - img).norm());
      }
    return Median(std::move(motions));
  }

  CameraModel camera_;
  std::optional<Subject> subject_;
  bool metric_;
  std::optional<Rigid3> last_pose_;
  std::deque<double> recent_detail_;
};

}  // namespace

std::unique_ptr<PoseSource> MakeKnownPoseSource(const CameraModel& camera,
                                                const std::optional<Subject>& subject, bool metric) {
  return std::make_unique<KnownPoseSource>(camera, subject, metric);
}

}  // namespace ulf::tracking
