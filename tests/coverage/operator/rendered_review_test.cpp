// Tests: coverage/operator/rendered_review.
//
// The review's picture is the renderer's own of the same views and mesh, also as a camera with distortion
// sees it, and follows the capture.
#include "coverage/operator/rendered_review.h"

#include <gmock/gmock.h>

#include <chrono>
#include <opencv2/imgproc.hpp>
#include <random>
#include <thread>

#include "core/light_field/folder/light_field_io.h"
#include "core/light_field/folder/light_field_writer.h"
#include "coverage/session/record/live_geometry.h"
#include "render/fields/field_options.h"
#include "render/proxy/proxy.h"
#include "tests/coverage/operator/display_stage.h"
#include "tests/support/test_paths.h"

namespace ulf::test::rendered_review_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kWhole = 0.01;  // no picture is drawn smaller

// A staged capture whose views are on disk.
class Staged {
 public:
  explicit Staged(const std::vector<double>& azimuths_deg = {-10, -5, 0, 5, 10})
      : capture_({.width = kWidth, .height = kHeight, .rendered = true}) {
    // Not on a grid, where rounding decides which way its squares are cut into triangles.
    std::mt19937 random(1);
    std::uniform_real_distribution<double> off(-1, 1);
    for (const double elevation : {-5, 0, 5})
      for (const double azimuth : azimuths_deg)
        capture_.Record(capture_.CameraAt(azimuth + off(random), elevation + off(random)));
    CaptureHeader header;
    header.camera = capture_.camera();
    header.threshold_px = 12;
    LightFieldWriter writer = LightFieldWriter::Create(dir(), header);
    writer.SetSubject(capture_.subject());
    for (const auto& state : capture_.recorded()) {
      View view;
      view.cam_from_world = state->newest_view->cam_from_world;
      writer.AddView(state->newest_view->frame, view);
    }
    writer.Close(1, {});
  }
  std::filesystem::path dir() const { return scratch_ / "lf"; }
  StagedCapture& capture() { return capture_; }
  const StagedCapture& capture() const { return capture_; }
  const CameraModel& camera() const { return capture_.camera(); }
  std::shared_ptr<CaptureState> State(double azimuth_deg = 1, double elevation_deg = 2) const {
    auto state = capture_.At(capture_.CameraAt(azimuth_deg, elevation_deg));
    state->light_field = dir();
    state->mesh = mesh_;
    return state;
  }
  // Two triangles through the subject that face the first view: any mesh will do.
  void MakeMesh(double nearer = 0) {
    const Rigid3 world_from_cam = capture_.CameraAt(0, 0).Inverse();
    auto triangles = std::make_shared<TriangleMesh>();
    for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
      triangles->vertices.push_back((world_from_cam * Eigen::Vector3d(x, y, 1 - nearer)).cast<float>());
    triangles->triangles = {{0, 1, 2}, {0, 2, 3}};
    auto mesh = std::make_shared<LiveMesh>();
    mesh->subject = capture_.subject();
    mesh->mesh = std::move(triangles);
    mesh_ = std::move(mesh);
  }
  std::shared_ptr<const LiveMesh> mesh() const { return mesh_; }

 private:
  ScratchFolder scratch_;
  StagedCapture capture_;
  std::shared_ptr<const LiveMesh> mesh_;
};

// Draws until nothing is missing any more, as a display does, or for twenty seconds.
cv::Mat DrawnBy(RenderedReview& review, const CaptureState& state, const CameraModel& camera) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  double now_s = 0;
  std::optional<unsigned> drawn;
  do {
    review.Follow(state, now_s += 2);
    drawn = review.Draw(camera, *state.cam_from_world);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  } while ((!drawn || review.is_loading()) && std::chrono::steady_clock::now() < until);
  EXPECT_TRUE(drawn);
  EXPECT_FALSE(review.is_loading());
  return drawn ? review.Read() : cv::Mat();
}

// What `ulf view` and `ulf render` draw.
cv::Mat Rendered(const Staged& staged, const CameraModel& camera, const Rigid3& cam_from_world) {
  const auto scene = LoadScene(ReadLightField(staged.dir()), {});
  std::shared_ptr<const Proxy> proxy = scene->proxy;
  if (staged.mesh()) proxy = std::make_shared<MeshProxy>(scene->subject, staged.mesh()->mesh);
  GlRenderer renderer(WithProxy(*scene, proxy), {.field = DefaultField(*scene)});
  return Srgb8FromLinear(renderer.Render(camera, cam_from_world).linear);
}

TEST(RenderedReview, IsThePictureOfTheRenderer) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  for (const bool has_mesh : {false, true}) {
    Staged staged;
    if (has_mesh) staged.MakeMesh(0.05);
    const auto state = staged.State();
    RenderedReview review(kWhole);
    review.SetHatchesDoubt(false);
    const CameraModel camera = staged.camera().WithoutDistortion();
    const cv::Mat drawn = DrawnBy(review, *state, camera);
    const cv::Mat expected = Rendered(staged, camera, *state->cam_from_world);
    ASSERT_EQ(drawn.size(), expected.size());
    EXPECT_GT(cv::PSNR(drawn, expected), 45) << has_mesh;
    EXPECT_FALSE(review.TakeProblem());
  }
}

// Of so few `ulf render` takes lumigraph weights.
TEST(RenderedReview, NineViewsAreDrawnAsTheRendererDoes) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  const Staged staged({-8, 0, 8});
  const auto scene = LoadScene(ReadLightField(staged.dir()), {});
  ASSERT_EQ(scene->mesh.span, Span::kSurface);
  EXPECT_EQ(DefaultField(*scene).kind, FieldKind::kLumigraph);
  RenderedReview review(kWhole);
  review.SetHatchesDoubt(false);
  const CameraModel camera = staged.camera().WithoutDistortion();
  const auto state = staged.State(4, 3);
  const cv::Mat drawn = DrawnBy(review, *state, camera);
  EXPECT_GT(cv::PSNR(drawn, Rendered(staged, camera, *state->cam_from_world)), 45);
  const Rigid3 here = *state->cam_from_world;
  GlRenderer by_subdivision(scene, {});
  const cv::Mat other = Srgb8FromLinear(by_subdivision.Render(camera, here).linear);
  EXPECT_LT(cv::PSNR(drawn, other), 45) << "else this test tells nothing";
}

TEST(RenderedReview, ADistortedCameraSeesItDistorted) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  const Staged staged;
  const auto state = staged.State();
  for (const double k1 : {-0.25, 0.15}) {
    CameraModel camera = CameraModel::Pinhole(kWidth, kHeight, 300);
    camera.distortion = Distortion::kRadialTangential;
    camera.coefficients[0] = k1;
    RenderedReview review(kWhole);
    const cv::Mat drawn = DrawnBy(review, *state, camera);
    const CameraModel wide = DistortedPicture::Undistorted(camera);
    EXPECT_EQ(wide.width > kWidth, k1 < 0) << "a barrel shows more";
    const cv::Mat straight = Rendered(staged, wide, *state->cam_from_world);
    cv::Mat x(kHeight, kWidth, CV_32F), y(kHeight, kWidth, CV_32F), expected;
    for (int row = 0; row < kHeight; ++row)
      for (int column = 0; column < kWidth; ++column) {
        const auto img = wide.ImgFromCam(*camera.RayFromImg({column + 0.5, row + 0.5}));
        x.at<float>(row, column) = static_cast<float>(img->x() - 0.5);
        y.at<float>(row, column) = static_cast<float>(img->y() - 0.5);
      }
    cv::remap(straight, expected, x, y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    EXPECT_GT(cv::PSNR(drawn, expected), 38) << k1;
  }
}

TEST(RenderedReview, FollowsViewsPosesAndMesh) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  Staged staged;
  RenderedReview review(kWhole);
  const CameraModel camera = staged.camera().WithoutDistortion();
  const cv::Mat at_first = DrawnBy(review, *staged.State(), camera);
  staged.MakeMesh(0.2);
  const cv::Mat over_mesh = DrawnBy(review, *staged.State(), camera);
  EXPECT_LT(cv::PSNR(at_first, over_mesh), 35) << "another depth";
  EXPECT_GT(cv::PSNR(over_mesh, Rendered(staged, camera, *staged.State()->cam_from_world)), 45);

  // A view that is taken back is gone at once, also before the scene has been read again.
  const int nearest = staged.State()->view_ids.back();
  staged.capture().TakeBack(nearest);
  review.Follow(*staged.State(), 1e9);
  review.Draw(camera, *staged.State()->cam_from_world);
  EXPECT_EQ(review.Shows(nearest), false);
  EXPECT_GT(cv::PSNR(DrawnBy(review, *staged.State(), camera), over_mesh), 25);
}

TEST(RenderedReview, StripesMarkWhereNoViewIsNear) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  const Staged staged;
  const CameraModel camera = staged.camera();
  const auto difference = [&](double azimuth_deg) {
    const auto state = staged.State(azimuth_deg, 0);
    RenderedReview review(kWhole);
    EXPECT_FALSE(review.hatches_doubt());
    const cv::Mat without = DrawnBy(review, *state, camera);
    review.SetHatchesDoubt(true);
    return cv::norm(without, DrawnBy(review, *state, camera), cv::NORM_L1) / (3.0 * kWidth * kHeight);
  };
  EXPECT_LT(difference(0), 6) << "among the views";
  EXPECT_GT(difference(35), 3 * difference(0)) << "beside them";
}

TEST(RenderedReview, IsSmallerInMotionWhenSlow) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  const Staged staged;
  const CameraModel camera = staged.camera().WithoutDistortion();
  RenderedReview review(1e6);
  DrawnBy(review, *staged.State(), camera);
  EXPECT_EQ(review.Read().size(), cv::Size(kWidth, kHeight)) << "at rest";
  for (int i = 0; i < 6; ++i) review.Draw(camera, staged.capture().CameraAt(0.1 * i, 0));
  EXPECT_EQ(review.Read().size(), cv::Size(kWidth / 4, kHeight / 4));
  review.Draw(camera, staged.capture().CameraAt(0.5, 0));
  EXPECT_EQ(review.Read().size(), cv::Size(kWidth, kHeight)) << "at rest again";
}

TEST(RenderedReview, SaysOnceWhatCannotBeRead) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  const Staged staged;
  std::filesystem::remove(staged.dir() / "journal.jsonl");
  std::filesystem::remove(staged.dir() / "transforms.json");
  RenderedReview review(kWhole);
  const auto state = staged.State();
  std::vector<std::string> problems;
  for (int i = 0; i < 30; ++i) {
    review.Follow(*state, 2 * i);
    EXPECT_FALSE(review.Draw(staged.camera(), *state->cam_from_world));
    if (const auto problem = review.TakeProblem()) problems.push_back(*problem);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_THAT(problems[0], HasSubstr(staged.dir().string()));
}

TEST(RenderedReview, RetriesAfterAWhileAndOnNewViews) {
  OffscreenSurface surface({640, 480});
  surface.Bind();
  Staged staged;
  const std::filesystem::path journal = staged.dir() / "journal.jsonl", away = staged.dir() / "away";
  std::filesystem::rename(journal, away);
  std::filesystem::remove(staged.dir() / "transforms.json");
  RenderedReview review(kWhole);
  const auto draws = [&](double from_s, double to_s) {
    const auto state = staged.State();
    bool drawn = false;
    for (double now_s = from_s; now_s <= to_s; now_s += 1) {
      review.Follow(*state, now_s);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      drawn |= review.Draw(staged.camera(), *state->cam_from_world).has_value();
    }
    return drawn;
  };
  double failed_s = 0;
  for (std::optional<std::string> problem; !problem && failed_s < 1000; problem = review.TakeProblem())
    draws(failed_s, failed_s), ++failed_s;
  std::filesystem::rename(away, journal);
  EXPECT_FALSE(draws(failed_s, failed_s + 30)) << "nothing has changed";
  std::filesystem::rename(journal, away);
  staged.MakeMesh();
  EXPECT_FALSE(draws(failed_s + 31, failed_s + 34));
  ASSERT_FALSE(review.TakeProblem()) << "said once";
  std::filesystem::rename(away, journal);
  staged.MakeMesh(0.1);
  EXPECT_FALSE(draws(failed_s + 35, failed_s + 40)) << "too soon";
  DrawnBy(review, *staged.State(), staged.camera());

  std::filesystem::rename(journal, away);
  review.Close();
  EXPECT_FALSE(draws(0, 5));
  std::filesystem::rename(away, journal);
  review.Close();
  DrawnBy(review, *staged.State(), staged.camera());
}

}  // namespace
}  // namespace ulf::test::rendered_review_test
