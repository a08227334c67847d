// Tests: render/prediction/error_cause.
//
// Each cause made alone in a simulated scene, and what it is named: the table of both is printed.
#include "render/prediction/error_cause.h"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>

#include "core/geometry/angles.h"
#include "tests/render/prediction/seen_scene.h"
#include "tests/support/floors.h"

namespace ulf::error_cause_test {
namespace {

using Eigen::Vector3d;
using test::SeenScene;

constexpr int kDrawnPx = 640;

const SeenScene& Studio() {
  static const SeenScene scene("studio", Radians(5), kDrawnPx);
  return scene;
}

// Of a pose that is known.
ErrorCause Named(FramePredictor& predictor, const StereoView& frame) {
  const auto predicted = predictor.Predict(frame);
  if (!predicted) return ErrorCause::kNotSeen;
  return CauseOf(MeasureError(frame, *predicted, predictor.subject(), {.center_sigma = 0.0}));
}

// Places between the views, and beyond them for what nobody has seen.
constexpr int kPlaces = 8;
Rigid3 Place(const SeenScene& scene, int i) {
  return scene.PoseFrom(Radians(-11.5 + 3.1 * i), Radians(i % 2 == 0 ? 2.4 : -2.2));
}

// What a camera sees there of the studio: most causes begin with these.
StereoView StudioLook(int i) {
  static const std::vector<StereoView> looks = [] {
    std::vector<StereoView> made;
    for (int place = 0; place < kPlaces; ++place)
      made.push_back(Studio().Look(Place(Studio(), place), static_cast<unsigned>(1000 + place)));
    return made;
  }();
  StereoView look = looks[static_cast<std::size_t>(i)];
  look.grey = look.grey.clone();
  return look;
}

std::vector<ErrorCause> NamedAtPlaces(const std::function<ErrorCause(int)>& at) {
  std::vector<ErrorCause> named;
  for (int i = 0; i < kPlaces; ++i) named.push_back(at(i));
  return named;
}

std::vector<ErrorCause> NamedOf(ErrorCause cause) {
  const auto seed = [](int i) { return static_cast<unsigned>(1000 + i); };
  switch (cause) {
    case ErrorCause::kNone: {
      FramePredictor predictor = Studio().Predictor();
      return NamedAtPlaces([&](int i) { return Named(predictor, StudioLook(i)); });
    }
    case ErrorCause::kNotSeen: {
      FramePredictor predictor = Studio().Predictor();
      auto part = std::make_shared<TriangleMesh>(*Studio().mesh());
      const Vector3d center = Studio().subject().center_in_world;
      std::erase_if(part->triangles, [&](const std::array<std::uint32_t, 3>& triangle) {
        return (part->vertices[triangle[0]].cast<double>() - center).norm() < 1.5 * Studio().subject().radius;
      });
      predictor.SetGeometry(Studio().subject(), part);
      return NamedAtPlaces([&](int i) { return Named(predictor, StudioLook(i)); });
    }
    case ErrorCause::kPose: {
      FramePredictor predictor = Studio().Predictor();
      return NamedAtPlaces([&](int i) {
        StereoView frame = StudioLook(i);
        const Eigen::AngleAxisd turn((2 + 0.3 * i) / frame.camera.fx, Vector3d(0.3, 1, 0.1 * i).normalized());
        frame.cam_from_world.rotation = turn * frame.cam_from_world.rotation;
        frame.cam_from_world.translation = turn * frame.cam_from_world.translation;
        return Named(predictor, frame);
      });
    }
    case ErrorCause::kLight: {
      FramePredictor predictor = Studio().Predictor();
      return NamedAtPlaces([&](int i) {
        StereoView frame = StudioLook(i);
        // Somebody stands in the light: brightness falls across the picture, another way every time.
        for (int y = 0; y < frame.grey.rows; ++y)
          for (int x = 0; x < frame.grey.cols; ++x) {
            const float along = static_cast<float>(i % 2 == 0 ? x : frame.grey.cols - 1 - x) /
                                static_cast<float>(frame.grey.cols);
            frame.grey.at<float>(y, x) *= 1 - 0.7f * along;
          }
        return Named(predictor, frame);
      });
    }
    case ErrorCause::kFocus: {
      FramePredictor predictor = Studio().Predictor();
      return NamedAtPlaces([&](int i) {
        StereoView frame = StudioLook(i);
        cv::GaussianBlur(frame.grey, frame.grey, {}, 1.5 + 0.2 * i);
        return Named(predictor, frame);
      });
    }
    case ErrorCause::kMoved: {
      static const SeenScene branch("branch", Radians(5), kDrawnPx);
      FramePredictor predictor = branch.Predictor();
      return NamedAtPlaces(
          [&](int i) { return Named(predictor, branch.Look(Place(branch, i), seed(i), 0.4 + 0.07 * i)); });
    }
    case ErrorCause::kGeometry: {
      // Ten in a hundred nearer to the first viewpoint than it is.
      FramePredictor predictor = Studio().Predictor();
      auto wrong = std::make_shared<TriangleMesh>(*Studio().mesh());
      const Vector3d from = Studio().PoseFrom(0, 0).OriginInSource();
      for (auto& vertex : wrong->vertices)
        vertex = (from + 0.9 * (vertex.cast<double>() - from)).cast<float>();
      predictor.SetGeometry(Studio().subject(), wrong);
      return NamedAtPlaces([&](int i) { return Named(predictor, StudioLook(i)); });
    }
    case ErrorCause::kSurface: {
      static const SeenScene glass("glass", Radians(10), kDrawnPx);
      FramePredictor predictor = glass.Predictor();
      return NamedAtPlaces([&](int i) { return Named(predictor, glass.Look(Place(glass, i), seed(i))); });
    }
    case ErrorCause::kDetail: {
      // Few views, over the surfaces that many have found.
      static const SeenScene sparse("studio", Radians(12), kDrawnPx);
      FramePredictor predictor = sparse.Predictor();
      predictor.SetGeometry(Studio().subject(), Studio().mesh());
      return NamedAtPlaces([&](int i) { return Named(predictor, sparse.Look(Place(sparse, i), seed(i))); });
    }
  }
  return {};
}

TEST(ErrorCause, IsNamedByTheEvidenceInTheDifference) {
  fmt::print("{:10}", "made");
  for (const ErrorCause cause : kErrorCauses) fmt::print(" {:>9}", Name(cause));
  fmt::print("\n");
  for (const ErrorCause made : kErrorCauses) {
    std::map<ErrorCause, int> named;
    for (const ErrorCause cause : NamedOf(made)) ++named[cause];
    fmt::print("{:10}", Name(made));
    for (const ErrorCause cause : kErrorCauses) fmt::print(" {:>9}", named[cause]);
    fmt::print("\n");
    // At some places few views are enough: then nothing is wrong.
    const int fine = made == ErrorCause::kDetail ? named[ErrorCause::kNone] : 0;
    EXPECT_GE(named[made] + fine, 6) << "of " << kPlaces << ": " << Name(made);
    EXPECT_GE(named[made], 4) << "of " << kPlaces << ": " << Name(made);
  }
}

TEST(ErrorCause, EveryOneHasANameAndWords) {
  std::set<std::string> names, words;
  for (const ErrorCause cause : kErrorCauses) {
    names.insert(Name(cause));
    words.insert(InWords(cause));
  }
  EXPECT_EQ(names.size(), kErrorCauses.size());
  EXPECT_EQ(words.size(), kErrorCauses.size());
}

}  // namespace
}  // namespace ulf::error_cause_test
