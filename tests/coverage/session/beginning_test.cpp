// Tests: coverage/session/light_and_focus, coverage/session/subject_anchors,
// coverage/session/subject_proposal.
//
// A capture before its first view: nothing is recorded until somebody asks for it, what holds the start, and
// a sphere that follows the map and gets the subject's size.
#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>
#include <random>

#include "acquisition/simulator/simulated_camera.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/session/light_and_focus.h"
#include "coverage/session/subject_anchors.h"
#include "coverage/session/subject_proposal.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::beginning_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// A capture that waits to begin, and what is asked of it after which frame.
struct Waiting {
  CaptureOptions options = Options();
  std::multimap<std::uint64_t, CaptureRequest> after;  // frames
  std::vector<SharedCaptureState> states;
  std::vector<std::string> said;

  Waiting() { options.begins_on_request = true; }

  Captured Run(const std::vector<PlanarShot>& shots) {
    const ScratchFolder scratch;
    CaptureRequests requests;
    CaptureHooks hooks;
    hooks.requests = &requests;
    hooks.say = [&](const std::string& line) { said.push_back(line); };
    hooks.after_frame = [&](const SharedCaptureState& now) {
      states.push_back(now);
      const auto [from, to] = after.equal_range(now->frames);
      for (auto request = from; request != to; ++request) requests.Push(request->second);
    };
    return Capture(scratch / "lf", shots, options, {}, hooks);
  }
};

std::vector<PlanarShot> Steps(int count, Fault fault = Fault::kNone) {
  std::vector<PlanarShot> shots;
  for (int i = 0; i < count; ++i) shots.push_back({PoseAt(3.0 * i, 0), fault});
  return shots;
}

TEST(Beginning, NothingIsRecordedBeforeSomebodyAsks) {
  Waiting capture;
  EXPECT_EQ(capture.Run(Steps(6)).light_field.views.size(), 0u);
  EXPECT_TRUE(capture.states.back()->waits_to_begin);
  EXPECT_FALSE(capture.states.back()->recording);
  ASSERT_TRUE(capture.states.back()->subject) << "its sphere is shown and can be placed";
  EXPECT_FALSE(capture.states.back()->preflight.empty());

  Waiting asked;
  asked.after.emplace(3, SetRecording{true});
  const Captured captured = asked.Run(Steps(6));
  ASSERT_EQ(captured.light_field.views.size(), 3u);
  EXPECT_LT((captured.light_field.views[0].CenterInWorld() - PoseAt(9, 0).OriginInSource()).norm(), 1e-9);
  EXPECT_FALSE(asked.states.back()->waits_to_begin);
  EXPECT_THAT(asked.said, Contains("recording begins"));

  Waiting placed;
  const Subject elsewhere{{0.02, 0, 0}, 0.12};
  placed.after.emplace(2, PlaceSphere{elsewhere});
  placed.after.emplace(2, SetRecording{true});
  EXPECT_EQ(placed.Run(Steps(6)).light_field.subject, elsewhere);

  CaptureOptions by_itself = Options();
  const ScratchFolder scratch;
  EXPECT_EQ(Capture(scratch / "lf", Steps(6), by_itself).light_field.views.size(), 6u);
  by_itself.begins_on_request = true;
  EXPECT_EQ(Capture(scratch / "lf", {{PoseAt(30, 0)}}, by_itself).light_field.views.size(), 7u)
      << "a light field that has begun goes on";
}

TEST(Beginning, RequestWaitsForASubject) {
  Waiting capture;
  capture.after.emplace(1, SetRecording{true});
  capture.options.subject.reset();
  const ScratchFolder scratch;
  DriftingSource poses(Rigid3{});
  PlanarDevice device(Sweep(10, 4, 0.8));
  device.Start();
  CaptureRequests requests;
  requests.Push(SetRecording{true});
  CaptureHooks hooks;
  hooks.requests = &requests;
  std::vector<std::string> said;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  const CaptureSummary summary =
      RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), capture.options, hooks);
  EXPECT_GT(summary.recorded, 5u);
  EXPECT_THAT(said, Contains(HasSubstr("as soon as the subject is found")));
}

TEST(Beginning, RedItemsAreSaidOnRequestBeforeASubject) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> shots = Sweep(10, 4, 0.8);
  for (PlanarShot& shot : shots) shot.fault = Fault::kBlack;
  PlanarDevice device(shots);
  device.Start();
  DriftingSource poses(Rigid3{});
  CaptureOptions options = Options();
  options.begins_on_request = true;
  options.subject.reset();
  options.stable_frames = 1000;
  CaptureRequests requests;
  CaptureHooks hooks;
  hooks.requests = &requests;
  std::vector<std::string> said;
  hooks.say = [&](const std::string& line) { said.push_back(line); };
  hooks.after_frame = [&](const SharedCaptureState& now) {
    if (now->frames == 5) requests.Push(SetRecording{true});
  };
  EXPECT_EQ(RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), options, hooks).recorded, 0u);
  EXPECT_THAT(said, Contains(AllOf(HasSubstr("as soon as the subject is found"), HasSubstr("too dark"))));
}

// Darkness and too much light: each holds the start, says why, and can be overridden.
TEST(Beginning, ARedItemHoldsTheStartAndIsNamed) {
  struct Hindrance {
    Fault fault;
    const char* name;
    const char* way_out;
  };
  for (const Hindrance& red :
       {Hindrance{Fault::kBlack, "light", "add light"}, {Fault::kOverexposed, "light", "expose less"}}) {
    std::vector<PlanarShot> shots;
    for (int i = 0; i < 40; ++i) shots.push_back({PoseAt(0.1 * i, 0), red.fault});
    Waiting held;
    held.after.emplace(30, SetRecording{true});
    EXPECT_EQ(held.Run(shots).light_field.views.size(), 0u) << red.name;
    EXPECT_TRUE(held.states.back()->waits_to_begin) << red.name;
    EXPECT_THAT(held.said, Contains(AllOf(HasSubstr("recording has not begun: "), HasSubstr(red.name),
                                          HasSubstr(red.way_out), HasSubstr("force_start"))));
    // As soon as it is mended.
    for (int i = 0; i < 40; ++i) shots.push_back({PoseAt(4 + 0.1 * i, 0)});
    Waiting mended;
    mended.after.emplace(78, SetRecording{true});
    EXPECT_GE(mended.Run(shots).light_field.views.size(), 1u) << red.name;
    Waiting anyway;
    anyway.after.emplace(30, SetRecording{.on = true, .although_checks_fail = true});
    anyway.Run(shots);
    EXPECT_FALSE(anyway.states[35]->waits_to_begin) << red.name;
    EXPECT_THAT(anyway.said, Contains(AllOf(HasSubstr("all the same"), HasSubstr(red.name),
                                            HasSubstr("no view is recorded while it is so"))));
    Waiting forced;
    forced.options.checks_hold_start = false;
    forced.after.emplace(30, SetRecording{true});
    forced.Run(shots);
    EXPECT_FALSE(forced.states[35]->waits_to_begin) << red.name;
  }
}

TEST(Beginning, WarningsDoNotHoldTheStart) {
  Waiting capture;
  capture.options.calibrated = false;
  capture.after.emplace(2, SetRecording{true});
  EXPECT_EQ(capture.Run(Steps(6)).light_field.views.size(), 4u);
  EXPECT_THAT(capture.said, Contains(HasSubstr("calibration")));
}

// Discs of all sizes over each other, as things lie in photographs (dead leaves), with a camera's noise.
cv::Mat Leaves(const cv::Size& size, double largest_px, double blur_px) {
  cv::Mat picture(size, CV_8U, cv::Scalar(128));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 20000; ++i) {
    constexpr double kSmallest = 2;
    const double radius = kSmallest * std::pow(largest_px / kSmallest, share(random) * share(random));
    const cv::Point at(static_cast<int>(size.width * share(random)),
                       static_cast<int>(size.height * share(random)));
    cv::circle(picture, at, static_cast<int>(radius), cv::Scalar(30 + 190 * share(random)), cv::FILLED,
               cv::LINE_AA);
  }
  cv::GaussianBlur(picture, picture, {0, 0}, std::max(blur_px, 0.7));  // the lens and the sensor
  cv::Mat noise(picture.size(), CV_16S), noisy;
  cv::RNG(6).fill(noise, cv::RNG::NORMAL, 0, 2);
  picture.convertTo(noisy, CV_16S);
  noisy += noise;
  noisy.convertTo(noisy, CV_8U);
  return noisy;
}

std::vector<Eigen::Vector2d> Circle(const cv::Point2d& middle, double radius) {
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i < 64; ++i)
    outline.push_back(
        {middle.x + radius * std::cos(2 * M_PI * i / 64), middle.y + radius * std::sin(2 * M_PI * i / 64)});
  return outline;
}

TEST(FineDetail, TellsFocusWhateverTheScene) {
  const std::vector<Eigen::Vector2d> all{{0, 0}, {640, 0}, {640, 480}, {0, 480}};
  for (const double largest_px : {10.0, 40.0, 120.0}) {
    const auto sharp = FineDetail(Leaves({640, 480}, largest_px, 0), all);
    ASSERT_TRUE(sharp);
    EXPECT_GT(*sharp, 1) << largest_px;
    for (const double sigma : {3.0, 5.0}) {
      const auto blurred = FineDetail(Leaves({640, 480}, largest_px, sigma), all);
      ASSERT_TRUE(blurred) << largest_px;
      EXPECT_LT(*blurred, kLeastFineDetail) << largest_px << " blurred by " << sigma;
    }
  }
  cv::Mat plain(480, 640, CV_8U);
  cv::RNG(7).fill(plain, cv::RNG::NORMAL, 128, 2);
  EXPECT_FALSE(FineDetail(plain, all)) << "a plain wall tells nothing";
}

// A still of a smooth thing in the middle: its shape, its grey values, and what it stands before.
struct Still {
  cv::Mat shape, thing, background;  // 0 to 255, before the lens
  static constexpr double kRadius = 150;
  static inline const cv::Size kSize{1280, 960};
  static inline const cv::Point kMiddle{640, 480};

  Still(int thickness, const cv::Mat& before) : background(before) {
    shape = cv::Mat::zeros(kSize, CV_8U);
    cv::circle(shape, kMiddle, static_cast<int>(kRadius), 255, thickness, cv::LINE_AA);
    thing = cv::Mat(kSize, CV_8U, cv::Scalar(230));
  }
  // `grey` of a place as seen from the middle, shares of the radius.
  template <typename Grey>
  Still& Paint(const Grey& grey) {
    for (int y = 0; y < kSize.height; ++y)
      for (int x = 0; x < kSize.width; ++x)
        thing.at<std::uint8_t>(y, x) =
            cv::saturate_cast<std::uint8_t>(grey(Eigen::Vector2d(x - kMiddle.x, y - kMiddle.y) / kRadius));
    return *this;
  }
  cv::Mat Taken(double blur_px) const {
    constexpr double kLensPx = 0.7, kNoise = 1;
    cv::Mat share, before, picture;
    shape.convertTo(share, CV_32F, 1 / 255.0);
    cv::GaussianBlur(share, share, {0, 0}, kLensPx);
    thing.convertTo(picture, CV_32F);
    background.convertTo(before, CV_32F);
    picture = before.mul(1 - share) + picture.mul(share);
    if (blur_px > 0) cv::GaussianBlur(picture, picture, {0, 0}, blur_px);
    cv::Mat noise(kSize, CV_32F);
    cv::RNG(6).fill(noise, cv::RNG::NORMAL, 0, kNoise);
    picture += noise;
    picture.convertTo(picture, CV_8U);
    return picture;
  }
};

// What is sharp only at its outline, and what stands before a background that is rightly blurred.
TEST(FineDetail, OnASmoothSubjectIsThatOfItsOutline) {
  const cv::Mat black(Still::kSize, CV_8U, cv::Scalar(8)), white(Still::kSize, CV_8U, cv::Scalar(245));
  const cv::Mat blurred_background = Leaves(Still::kSize, 60, 5);
  const auto ball = [](const Eigen::Vector2d& at) {
    const double towards = std::sqrt(std::max(0.0, 1 - at.squaredNorm()));
    return 25 + 190 * std::max(0.0, 0.85 * towards - 0.15 * at.x() - 0.3 * at.y());
  };
  const auto rim_light = [](const Eigen::Vector2d& at) {
    const double lit = std::max(0.0, -at.normalized().dot(Eigen::Vector2d(2, 1).normalized()));
    return 12 + 180 * std::pow(lit, 3) * std::exp(-25 * std::max(0.0, 1 - at.norm()));
  };
  const std::map<std::string, Still> stills{
      {"a ball on black", Still(cv::FILLED, black).Paint(ball)},
      {"a ball before white", Still(cv::FILLED, white).Paint(ball)},
      {"a ball before a blurred background", Still(cv::FILLED, blurred_background).Paint(ball)},
      {"a black thing with a rim light", Still(cv::FILLED, black).Paint(rim_light)},
      {"a thin ring before a blurred background", Still(5, blurred_background)}};
  const double needed = kLeastFineDetail;
  const std::vector<Eigen::Vector2d> sphere = Circle(Still::kMiddle, 1.2 * Still::kRadius);
  const std::vector<Eigen::Vector2d> middle{{320, 240}, {960, 240}, {960, 720}, {320, 720}};
  for (const auto& [name, still] : stills) {
    const cv::Mat sharp_picture = still.Taken(0), blurred_picture = still.Taken(3);
    for (const auto& outline : {sphere, middle}) {
      const auto sharp = FineDetail(sharp_picture, outline), blurred = FineDetail(blurred_picture, outline);
      ASSERT_TRUE(sharp) << name;
      ASSERT_TRUE(blurred) << name;
      printf("%-40s %.2f, blurred %.2f\n", name.c_str(), *sharp, *blurred);
      EXPECT_GT(*sharp, needed) << name;
      EXPECT_LT(*blurred, needed) << name;
    }
  }
}

TEST(FineDetail, CountsOnlyInsideTheOutline) {
  const Still ring(5, cv::Mat(Still::kSize, CV_8U, cv::Scalar(8)));
  EXPECT_TRUE(FineDetail(ring.Taken(0), Circle(Still::kMiddle, 1.1 * Still::kRadius)));
  EXPECT_FALSE(FineDetail(ring.Taken(0), Circle(Still::kMiddle, 0.9 * Still::kRadius)))
      << "its box holds parts of the ring";
}

// These scenes, full of texture and nearly without, are in focus and well lit; so are the others.
TEST(LightAndFocusCheck, FindsOnlyBlurredScenesUnsharp) {
  for (const std::string name : {"studio", "gloss", "bust"}) {
    SimulationOptions options;
    options.scene = name;
    const SimulatedCamera camera(options);
    const Scene& scene = camera.scene();
    const Rigid3 pose =
        LookAt(scene.subject().center_in_world + scene.FirstDistance() * scene.FirstDirection(),
               scene.subject().center_in_world, scene.UpInWorld());
    const Image sharp{Srgb8FromLinear(camera.caster().Radiance(pose, 0) * camera.LightScale())};
    Image blurred;
    cv::GaussianBlur(sharp.pixels, blurred.pixels, {0, 0}, 3);
    for (const Image& image : {sharp, blurred}) {
      const bool is_sharp = image.pixels.data == sharp.pixels.data;
      LightAndFocusCheck check;
      PreflightInput input;
      for (const double time_s : {0.0, 0.5, 1.0, 1.5})
        input.picture = check.Update(time_s, image, camera.camera(), pose, scene.subject());
      printf("%-8s %s: fine detail %.2f, brightest tenth %.2f\n", name.c_str(),
             is_sharp ? "sharp" : "blurred", input.picture.fine_detail.value_or(-1),
             input.picture.light->brightest_tenth);
      for (const PreflightItem& item : Preflight(input)) {
        if (item.name == "light") {
          EXPECT_NE(item.in_order, false) << name << ": " << item.words;
        }
        if (item.name == "focus") {
          EXPECT_EQ(item.in_order == false, !is_sharp) << name << ": " << item.words;
        }
      }
    }
  }
}

TEST(SubjectAnchors, SphereMovesAndScalesWithItsPoints) {
  const Rigid3 late_from_live{Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Vector3d(1, 2, 3).normalized())),
                              {0.02, -0.01, 0.05}};
  DriftingSource poses(late_from_live);
  PlanarDevice device(Steps(3));
  device.Start();
  SubjectAnchors anchors;
  EXPECT_FALSE(anchors.Now(poses));
  for (int i = 0; i < 3; ++i) anchors.Add(kSubject, poses.Step(*device.Next(std::chrono::milliseconds(0))));
  EXPECT_LT((anchors.Now(poses)->center_in_world - kSubject.center_in_world).norm(), 1e-12);
  EXPECT_NEAR(anchors.Now(poses)->radius, kSubject.radius, 1e-12);
  poses.Adjust(true);
  EXPECT_LT((anchors.Now(poses)->center_in_world - late_from_live * kSubject.center_in_world).norm(), 1e-12);
  EXPECT_NEAR(anchors.Now(poses)->radius, kSubject.radius, 1e-12);
}

TEST(Beginning, TheSphereFollowsTheCorrectedMap) {
  const Rigid3 late_from_live{Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Vector3d::UnitZ())),
                              {0.04, 0, 0.01}};
  for (const bool at_the_end : {false, true}) {
    const ScratchFolder scratch;
    DriftingSource poses(late_from_live);
    const std::vector<PlanarShot> shots = Sweep(10, 4, 0.8);
    PlanarDevice device(shots);
    device.Start();
    CaptureHooks hooks;
    std::vector<std::string> said;
    hooks.say = [&](const std::string& line) { said.push_back(line); };
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (!at_the_end && now->frames == shots.size() - 1) poses.Adjust(true);
    };
    const CaptureSummary summary =
        RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), Options(), hooks);
    const Subject expected{late_from_live * kSubject.center_in_world, kSubject.radius};
    const LightField light_field = ReadLightField(scratch / "lf");
    ASSERT_TRUE(light_field.subject);
    EXPECT_LT((light_field.subject->center_in_world - expected.center_in_world).norm(), 1e-9);
    EXPECT_NEAR(light_field.subject->radius, expected.radius, 1e-9);
    EXPECT_EQ(light_field.subject, summary.map->subject()) << "the map is painted round it";
    EXPECT_THAT(said, Contains(HasSubstr("the subject's sphere moved with it")));
  }
}

// A tracker that loses its map after some frames and begins another one with the next.
class SourceWithANewMap : public DriftingSource {
 public:
  explicit SourceWithANewMap(int last_of_first) : DriftingSource(Rigid3{}), last_of_first_(last_of_first) {}
  Track Step(const Frame& frame) override {
    Track track = DriftingSource::Step(frame);
    ++frames_;
    track.map_id = frames_ > last_of_first_;
    if (frames_ == last_of_first_ + 1) track.state = TrackState::kLost, track.cam_from_world.reset();
    return track;
  }

 private:
  const int last_of_first_;
  int frames_ = 0;
};

// Asked to begin in the first map, where it is too dark, or in the second, before the subject is found again.
TEST(Beginning, RecordsNothingOnASphereOfALostMap) {
  constexpr std::uint64_t kFirstMap = 5;
  for (const std::uint64_t asked_after : {kFirstMap - 2, kFirstMap + 3}) {
    std::vector<PlanarShot> shots = Sweep(10, 4, 0.8);
    for (std::uint64_t i = 0; i < kFirstMap; ++i) shots[i].fault = Fault::kBlack;
    PlanarDevice device(shots);
    device.Start();
    SourceWithANewMap poses(static_cast<int>(kFirstMap));
    CaptureOptions options = Options();
    options.begins_on_request = true;
    CaptureRequests requests;
    std::vector<std::string> said;
    std::optional<std::uint64_t> found_at;
    CaptureHooks hooks;
    hooks.requests = &requests;
    hooks.say = [&](const std::string& line) { said.push_back(line); };
    hooks.after_frame = [&](const SharedCaptureState& now) {
      if (now->frames == asked_after) requests.Push(SetRecording{.on = true, .although_checks_fail = true});
      if (now->frames <= kFirstMap + 1) return;
      if (now->subject && !found_at) found_at = now->frames;
      if (found_at) return;
      EXPECT_EQ(now->decision.reason, Reason::kTracking) << now->frames;
      EXPECT_TRUE(now->view_ids.empty()) << now->frames;
      EXPECT_EQ(now->waits_to_begin, asked_after > kFirstMap) << now->frames;
    };
    const ScratchFolder scratch;
    const CaptureSummary summary =
        RunCapture(device, kCamera, poses, NewWriter(scratch / "lf"), options, hooks);
    ASSERT_TRUE(found_at);
    EXPECT_GE(*found_at, kFirstMap + 1 + static_cast<std::uint64_t>(options.stable_frames));
    EXPECT_GT(summary.recorded, 5u) << "it goes on with the new sphere";
    EXPECT_THAT(said, Contains(HasSubstr("the subject is looked for again")));
  }
}

std::shared_ptr<const LiveMesh> MeshThatShows(const std::optional<Subject>& seen, int maps = 20) {
  auto mesh = std::make_shared<LiveMesh>();
  mesh->maps = maps;
  mesh->subject_seen = seen;
  return mesh;
}

SubjectProposer Proposer() {
  static const CaptureLens kLens(kCamera);
  static const CaptureOptions kOptions = [] {
    CaptureOptions options;
    options.cap = Cap::FromDegrees({60, 40});
    options.until_share = 1;
    options.threshold_px = 12;
    return options;
  }();
  return SubjectProposer(kLens, kOptions);
}

TEST(SubjectProposer, ProposesTheSizeThatTwoMeshesShow) {
  for (const double ratio : {0.5, 0.9, 1.1, 1.6}) {
    SubjectProposer proposer = Proposer();
    const Subject seen{kSubject.center_in_world, ratio * kSubject.radius};
    EXPECT_FALSE(proposer.Update(MeshThatShows(seen), kSubject, 1)) << "one mesh may err";
    const auto proposal = proposer.Update(MeshThatShows(seen), kSubject, 1);
    ASSERT_EQ(proposal.has_value(), ratio < 0.65 || ratio > 1.33) << ratio;
    if (!proposal) continue;
    EXPECT_EQ(proposal->subject, seen);
    ASSERT_TRUE(proposal->views_now && proposal->views_then);
    EXPECT_EQ(*proposal->views_then < *proposal->views_now, ratio < 1)
        << "a smaller sphere takes fewer views";
    EXPECT_THAT(InWords(*proposal, kSubject),
                AllOf(HasSubstr(ratio < 1 ? "smaller" : "larger"), HasSubstr("views")));
    EXPECT_FALSE(proposer.Update(MeshThatShows(seen), kSubject, 1)) << "said once";
    EXPECT_TRUE(proposer.proposal());
    proposer.Update(MeshThatShows(seen), seen, 1);  // somebody has placed it
    EXPECT_FALSE(proposer.proposal());
  }
}

TEST(SubjectProposer, IsSilentOnDisagreeingOrPoorMeshes) {
  const Subject small{kSubject.center_in_world, 0.5 * kSubject.radius};
  const Subject smaller{kSubject.center_in_world, 0.3 * kSubject.radius};
  SubjectProposer proposer = Proposer();
  for (const auto& mesh : {MeshThatShows(small), MeshThatShows(smaller), MeshThatShows({}),
                           MeshThatShows(small), MeshThatShows(smaller), std::shared_ptr<const LiveMesh>()})
    EXPECT_FALSE(proposer.Update(mesh, kSubject, 1));
  for (int i = 0; i < 3; ++i)
    EXPECT_FALSE(proposer.Update(MeshThatShows(small, 4), kSubject, 1)) << "few maps";
  EXPECT_FALSE(proposer.proposal());
}

TEST(SubjectProposer, OffCentreSubjectLiesByItsSphere) {
  SubjectProposer proposer = Proposer();
  const auto seen = [](double offset) {
    return Subject{kSubject.center_in_world + Vector3d(offset * kSubject.radius, 0, 0),
                   0.9 * kSubject.radius};
  };
  EXPECT_FALSE(proposer.Update(MeshThatShows(seen(0.5)), kSubject, 1));
  EXPECT_FALSE(proposer.Update(MeshThatShows(seen(0.8)), kSubject, 1))
      << "two meshes disagree about its place";
  const auto proposal = proposer.Update(MeshThatShows(seen(0.8)), kSubject, 1);
  ASSERT_TRUE(proposal);
  EXPECT_THAT(InWords(*proposal, kSubject), AllOf(HasSubstr("beside"), HasSubstr("80 %"),
                                                  HasSubstr("sticks out"), Not(HasSubstr("smaller"))));
  proposer.Update(MeshThatShows(seen(0.5)), kSubject, 1);
  EXPECT_TRUE(proposer.Update(MeshThatShows(seen(0.5)), kSubject, 1)) << "elsewhere is another proposal";
  const Subject moved{seen(0.5).center_in_world, kSubject.radius};
  EXPECT_FALSE(proposer.Update(MeshThatShows(seen(0.5)), moved, 1));
  EXPECT_FALSE(proposer.proposal()) << "somebody has placed the sphere there";
}

TEST(Beginning, AnswersARequestForAMissingProposal) {
  Waiting capture;
  capture.after.emplace(1, ParseCaptureRequest("subject proposed"));
  capture.after.emplace(1, ParseCaptureRequest("record anyway"));
  EXPECT_EQ(capture.Run(Steps(4)).light_field.views.size(), 3u);
  EXPECT_THAT(capture.said, Contains(HasSubstr("no other sphere is proposed")));
}

}  // namespace
}  // namespace ulf::test::beginning_test
