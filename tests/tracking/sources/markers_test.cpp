// Tests: tracking/sources/board_from_map, tracking/sources/features_and_markers,
// tracking/sources/marker_locator, tracking/sources/marker_map, tracking/sources/marker_pose_source,
// tracking/sources/marker_spec.
// Poses from markers and boards: against the simulator's truth in millimetres, the two poses of a plane,
// markers that are learnt, features beside the board, and photographs of real ones.
#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "acquisition/simulator/simulated_board.h"
#include "acquisition/simulator/simulated_camera.h"
#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/fiducials/marker_detector.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"
#include "tracking/sources/board_from_map.h"
#include "tracking/sources/marker_locator.h"
#include "tracking/sources/poses_spec.h"
#include "tracking/tracker/pose_source.h"

namespace ulf::markers_test {
namespace {

using ::testing::HasSubstr;

BoardScene SceneOf(const std::string& board, const std::string& lens = "barrel", std::uint64_t seed = 7) {
  BoardSceneOptions options;
  options.board = Board::Parse(board);
  options.camera = SimulatedLens(lens, 640, 480);
  options.seed = seed;
  return BoardScene(options);
}

Rigid3 InMetres(const Rigid3& cam_from_board_mm) {
  return {cam_from_board_mm.rotation, 0.001 * cam_from_board_mm.translation};
}

// As GrayForTracking gives it: the simulated sensor is linear.
cv::Mat Picture(const BoardScene& scene, const Rigid3& cam_from_board, int noise) {
  return GrayForTracking(
      {scene.Render(cam_from_board, static_cast<std::uint64_t>(noise)), Transfer::kLinear});
}

double CentreErrorMm(const Rigid3& pose, const Rigid3& truth) {
  return 1000 * (pose.OriginInSource() - truth.OriginInSource()).norm();
}

double TurnDeg(const Rigid3& a, const Rigid3& b) {
  return RotationAngle(a.rotation * b.rotation.conjugate()) * 180 / M_PI;
}

Frame FrameOf(const cv::Mat& gray, double time_s) {
  Frame frame;
  frame.image = {gray, Transfer::kSrgb};
  frame.device_time_s = time_s;
  return frame;
}

// One every day; with ULF_STABILITY=seeds five.
std::vector<std::uint64_t> Seeds() {
  const char* asked = std::getenv("ULF_STABILITY");
  if (asked && std::string(asked) == "seeds") return {7, 8, 9, 10, 11};
  return {7};
}

TEST(MarkerSpec, RefusalsNameTheCause) {
  const std::pair<const char*, const char*> kCases[] = {{"chessboard:8x6:25", "half a turn"},
                                                        {"dots", "charuco:"},
                                                        {"marker:80", "marker:80:"},
                                                        {"marker:80:DICT_9X9:1", "DICT_9X9"},
                                                        {"marker:-4:DICT_4X4_50:1", "SIDE_MM"},
                                                        {"marker:40:DICT_4X4_50:one", "'one'"}};
  for (const auto& [text, mentioned] : kCases) {
    EXPECT_THAT([&text = text] { MarkerSpec::Parse(text); },
                testing::ThrowsMessage<Refusal>(HasSubstr(mentioned)))
        << text;
  }
  EXPECT_EQ(MarkerSpec::Parse("marker:40:DICT_4X4_50:7").id, 7);
  EXPECT_EQ(MarkerSpec::Parse("marker:40:DICT_4X4_50").kind, MarkerSpec::Kind::kSeveral);
  EXPECT_THROW(PosesSpec::Parse("markers:dots"), Refusal);
}

// A board in a hand, behind lenses with and without distortion: metric from the first frame, a fraction of a
// millimetre, and the predicted error is of the true one's size.
TEST(Markers, ABoardsPoseIsMetric) {
  struct Case {
    const char *board, *lens;
    double within_mm;
  };
  for (const Case& c :
       {Case{"aruco:4x5:37.5:5:DICT_6X6_1000", "barrel", 0.6},
        Case{"charuco:7x5:30:22:DICT_5X5_100", "barrel", 0.4}, Case{"aprilgrid:6x6:30:9", "barrel", 0.6},
        Case{"aruco:4x5:37.5:5:DICT_6X6_1000:right-up:first=40", "barrel", 0.6},
        Case{"aruco:4x5:37.5:5:DICT_6X6_1000", "fisheye", 1.2}}) {
    const BoardScene scene = SceneOf(c.board, c.lens);
    const auto source = PosesSpec::Parse("markers:" + std::string(c.board)).Open(scene.options().camera, {});
    EXPECT_TRUE(source->IsMetric());
    std::vector<double> errors_mm, turns_deg, in_sigmas, qualities;
    constexpr int kStops = 14;
    for (int stop = 0; stop < kStops; ++stop) {
      const Rigid3 truth = scene.HeldAt(static_cast<std::uint64_t>(stop), 0);
      const cv::Mat gray = Picture(scene, truth, stop);
      const Track track = source->Step(FrameOf(gray, stop / 30.0));
      if (!track.cam_from_world) continue;
      EXPECT_EQ(track.state, TrackState::kTracking);
      ASSERT_TRUE(track.center_sigma);
      qualities.push_back(track.quality);
      errors_mm.push_back(CentreErrorMm(*track.cam_from_world, InMetres(truth)));
      turns_deg.push_back(TurnDeg(*track.cam_from_world, InMetres(truth)));
      in_sigmas.push_back(errors_mm.back() / (1000 * *track.center_sigma));
    }
    std::printf("%s, %s: %zu of %d, centre %.2f mm (95 %%: %.2f), turn %.3f deg, error / predicted %.2f\n",
                c.board, c.lens, errors_mm.size(), kStops, Median(errors_mm), Quantile(errors_mm, 0.95),
                Median(turns_deg), Median(in_sigmas));
    EXPECT_GE(errors_mm.size(), 13u) << c.board;
    EXPECT_LT(Median(errors_mm), c.within_mm) << c.board;
    EXPECT_LT(Quantile(errors_mm, 0.95), 5 * c.within_mm) << c.board;
    EXPECT_GT(Median(qualities), 0.5) << c.board;
    EXPECT_GT(Median(in_sigmas), 0.1) << c.board;
    EXPECT_LT(Median(in_sigmas), 3) << c.board;
  }
}

// Something stands on the middle of a ChArUco board, so that few of its squares meet in sight.
TEST(Markers, HalfHiddenBoardIsFoundByItsMarkers) {
  const char* board = "charuco:5x5:54:40:DICT_4X4_50";
  const BoardScene scene = SceneOf(board, "barrel");
  const auto source = PosesSpec::Parse("markers:" + std::string(board)).Open(scene.options().camera, {});
  std::vector<double> errors_mm;
  constexpr int kStops = 12;
  for (int stop = 0; stop < kStops; ++stop) {
    const Rigid3 truth = scene.HeldAt(static_cast<std::uint64_t>(stop), 0);
    cv::Mat gray = Picture(scene, truth, stop);
    const auto middle = scene.options().camera.ImgFromCam(truth * Eigen::Vector3d(135, 135, 0));
    const auto rim = scene.options().camera.ImgFromCam(truth * Eigen::Vector3d(135 + 75, 135, 0));
    ASSERT_TRUE(middle && rim);
    cv::circle(gray, {static_cast<int>(middle->x()), static_cast<int>(middle->y())},
               static_cast<int>((*rim - *middle).norm()), cv::Scalar(90), cv::FILLED);
    const Track track = source->Step(FrameOf(gray, stop / 30.0));
    if (track.cam_from_world) errors_mm.push_back(CentreErrorMm(*track.cam_from_world, InMetres(truth)));
  }
  EXPECT_GE(errors_mm.size(), 11u);
  EXPECT_LT(Median(errors_mm), 2);
}

// A small marker far away, without history: either the right one of its two poses or none. The nearer one in
// the image alone would have been wrong in some.
TEST(Markers, AmbiguousPosesAreNotGuessed) {
  BoardSceneOptions options;
  options.board = Board::Parse("aruco:1x1:40:10:DICT_4X4_50");
  options.camera = SimulatedLens("pinhole", 640, 480);
  const BoardScene scene(options);
  const MarkerSpec spec = MarkerSpec::Parse("marker:40:DICT_4X4_50:0");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0, 1);
  int seen = 0, given = 0, wrong = 0, guessed_wrong = 0;
  constexpr int kMarkers = 90;
  for (int i = 0; i < kMarkers; ++i) {
    const double size_px = 16 + 40 * uniform(random);
    const double distance_mm = options.camera.MeanFocalPx() * 40 / size_px;
    const double tilt = 50 * M_PI / 180 * uniform(random), about = 2 * M_PI * uniform(random);
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(about), std::sin(about), 0)));
    const Eigen::Vector3d middle(20, 20, 0);
    const Eigen::Vector3d place(0.3 * distance_mm * (uniform(random) - 0.5),
                                0.3 * distance_mm * (uniform(random) - 0.5), distance_mm);
    const Rigid3 cam_from_board{turn, place - turn * middle};
    const Rigid3 truth = Rigid3{turn, 0.001 * place};  // the marker's own frame begins in its middle
    const cv::Mat gray = Picture(scene, cam_from_board, i);
    const auto sure = MarkerLocator(options.camera, spec).Locate(gray, 0);
    const auto guess = MarkerLocator(options.camera, spec, 0).Locate(gray, 0);
    constexpr double kOtherPoseDeg = 12;
    seen += guess.has_value();
    guessed_wrong += guess && TurnDeg(guess->cam_from_world, truth) > kOtherPoseDeg;
    given += sure.has_value();
    wrong += sure && TurnDeg(sure->cam_from_world, truth) > kOtherPoseDeg;
  }
  std::printf("of %d single markers of 16 to 56 px %d seen, %d sure, %d of them wrong; guessing: %d wrong\n",
              kMarkers, seen, given, wrong, guessed_wrong);
  EXPECT_GT(seen, 72);
  EXPECT_GT(given, 24);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(guessed_wrong, 0);
}

// What the frame before knew decides where the corners cannot.
TEST(Markers, HistoryCarriesThroughAmbiguousFrames) {
  BoardSceneOptions options;
  options.board = Board::Parse("aruco:1x1:40:10:DICT_4X4_50");
  options.camera = CameraModel::Pinhole(240, 180, 560);  // no more than the marker needs
  const BoardScene scene(options);
  const MarkerSpec spec = MarkerSpec::Parse("marker:40:DICT_4X4_50:0");
  MarkerLocator following(options.camera, spec);
  int alone = 0, followed = 0, by_history = 0, wrong = 0;
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    // From near, where all is clear, back to where it is not.
    const double distance_mm = 350 + 20.0 * i;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.8, 0.6, 0)));
    const Rigid3 cam_from_board{turn, Eigen::Vector3d(0, 0, distance_mm) - turn * Eigen::Vector3d(20, 20, 0)};
    const cv::Mat gray = Picture(scene, cam_from_board, i);
    alone += MarkerLocator(options.camera, spec).Locate(gray, 0).has_value();
    const auto pose = following.Locate(gray, i / 30.0);
    followed += pose.has_value();
    by_history += pose && pose->by_history;
    wrong += pose && TurnDeg(pose->cam_from_world, {turn, {}}) > 12;
  }
  std::printf("%d of %d frames alone, %d with history (%d by it)\n", alone, kFrames, followed, by_history);
  EXPECT_LT(alone, followed);
  EXPECT_GT(by_history, 3);
  EXPECT_GT(followed, kFrames * 7 / 10);
  EXPECT_EQ(wrong, 0);
}

// Four markers whose arrangement nobody told: learnt to a fraction of a millimetre.
TEST(Markers, AnArrangementIsLearnt) {
  const BoardScene scene = SceneOf("aruco:2x2:60:30:DICT_4X4_50");
  MarkerLocator locator(scene.options().camera, MarkerSpec::Parse("marker:60:DICT_4X4_50"));
  std::vector<double> errors_mm;
  int first = -1;
  for (int i = 0; i < 60; ++i) {
    const Rigid3 truth = scene.HeldAt(static_cast<std::uint64_t>(i / 3), (i % 3) / 3.0);
    const auto pose = locator.Locate(Picture(scene, truth, i), i / 10.0);
    if (!pose) continue;
    // The world is the first marker's middle: which one that is shows in the first pose.
    const Rigid3 board_from_world = InMetres(truth).Inverse() * pose->cam_from_world;
    if (first < 0) {
      for (int id = 0; id < 4; ++id) {
        const Eigen::Vector3d middle(0.03 + 0.09 * (id % 2), 0.03 + 0.09 * (id / 2), 0);
        if ((board_from_world.translation - middle).norm() < 0.02) first = id;
      }
      ASSERT_GE(first, 0);
    }
    const Eigen::Vector3d middle(0.03 + 0.09 * (first % 2), 0.03 + 0.09 * (first / 2), 0);
    const Rigid3 expected = InMetres(truth) * Rigid3{Eigen::Quaterniond::Identity(), middle};
    if (i >= 40) errors_mm.push_back(CentreErrorMm(pose->cam_from_world, expected));
  }
  std::printf("%s; centre %.2f mm (95 %%: %.2f)\n", locator.WorldInWords().c_str(), Median(errors_mm),
              Quantile(errors_mm, 0.95));
  EXPECT_THAT(locator.WorldInWords(), ::testing::HasSubstr("4 markers learnt"));
  EXPECT_GE(errors_mm.size(), 18u);
  EXPECT_LT(Median(errors_mm), 1.5);
}

// The studio with a board on an easel, in the board's own frame, in millimetres, without any alignment.
// Covered up for a while; then in a fog that leaves only the board.
struct BesideABoard {
  explicit BesideABoard(std::uint64_t seed) : camera(OptionsOf(seed)), standing(*camera.scene().board()) {}
  static SimulationOptions OptionsOf(std::uint64_t seed) {
    SimulationOptions options;
    options.scene = "easel";
    options.looks_away = false;
    options.fps = 10;
    options.seed = seed;
    return options;
  }
  enum class Hidden { kNothing, kBoard, kAllElse };
  Frame At(int i, Hidden hidden) const {
    Frame frame = camera.Capture(static_cast<std::uint64_t>(i));
    frame.known_cam_from_world.reset();
    if (hidden == Hidden::kNothing) return frame;
    std::vector<cv::Point> outline;
    const double w = 0.001 * standing.board.WidthMm() + 0.02, h = 0.001 * standing.board.HeightMm() + 0.02;
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(-0.02, -0.02, 0), {w, -0.02, 0}, {w, h, 0}, {-0.02, h, 0}})
      if (const auto img = camera.camera().ImgFromCam(Truth(frame) * corner))
        outline.emplace_back(static_cast<int>(img->x()), static_cast<int>(img->y()));
    const bool board = hidden == Hidden::kBoard;
    cv::Mat mask(frame.image.pixels.size(), CV_8U, cv::Scalar(board ? 0 : 255));
    cv::fillConvexPoly(mask, outline, cv::Scalar(board ? 255 : 0));
    cv::Mat pixels = frame.image.pixels.clone();
    pixels.setTo(cv::Scalar::all(90), mask);
    frame.image.pixels = pixels;
    return frame;
  }
  Rigid3 Truth(const Frame& frame) const {
    return camera.hand().CamFromWorld(frame.device_time_s) * standing.board_from_world.Inverse();
  }
  std::unique_ptr<PoseSource> Open(const char* kind) const {
    return PosesSpec::Parse(kind + standing.board.Text())
        .Open(camera.camera(), {.tracker = {.deterministic = true}});
  }
  SimulatedCamera camera;
  const StandingBoard& standing;
};

// Seed 7, all in sight: rendered once for the tests that look at it.
const BesideABoard& Easel() {
  static const BesideABoard easel(7);
  return easel;
}

const Frame& EaselFrame(int i) {
  static std::vector<Frame> frames;
  while (static_cast<int>(frames.size()) <= i)
    frames.push_back(Easel().At(static_cast<int>(frames.size()), BesideABoard::Hidden::kNothing));
  return frames[static_cast<std::size_t>(i)];
}

// With features, a board in sight gives poses no worse than by itself; they carry while it is covered, and it
// carries while they are.
TEST(Markers, FeaturesAndBoardHelpEachOther) {
  constexpr int kCovered = 36, kFog = 48, kEnd = 55;
  std::vector<double> by_board_mm, open_mm, covered_mm, fog_mm, final_mm;
  for (const std::uint64_t seed : Seeds()) {
    const BesideABoard scene(seed);
    const auto both = scene.Open("features+markers:"), board = scene.Open("markers:");
    EXPECT_TRUE(both->IsMetric());
    std::vector<double> in_sight_mm, alone_mm, hidden_mm, carried_mm, after_mm;
    std::vector<std::pair<Anchored, Rigid3>> anchors;
    for (int i = 0; i < kEnd; ++i) {
      const auto hidden = i < kCovered ? BesideABoard::Hidden::kNothing
                          : i < kFog   ? BesideABoard::Hidden::kBoard
                                       : BesideABoard::Hidden::kAllElse;
      const Frame frame = scene.At(i, hidden);
      const Rigid3 truth = scene.Truth(frame);
      if (const Track alone = board->Step(frame); alone.cam_from_world && i < kCovered)
        alone_mm.push_back(CentreErrorMm(*alone.cam_from_world, truth));
      const Track track = both->Step(frame);
      ASSERT_TRUE(track.cam_from_world || i > 0) << "the board gives a pose at once";
      if (!track.cam_from_world) continue;
      (i < kCovered ? in_sight_mm
       : i < kFog   ? hidden_mm
                    : carried_mm)
          .push_back(CentreErrorMm(*track.cam_from_world, truth));
      anchors.emplace_back(*track.anchor, truth);
    }
    both->Finish();
    for (const auto& [anchor, truth] : anchors)
      after_mm.push_back(CentreErrorMm(both->PoseOf(anchor), truth));
    std::printf(
        "seed %d: board alone %.2f mm, with both %.2f; board covered %.2f, board alone in a fog %.2f; after "
        "the run %.2f (95 %%: %.2f); %d points\n",
        static_cast<int>(seed), Median(alone_mm), Median(in_sight_mm), Median(hidden_mm), Median(carried_mm),
        Median(after_mm), Quantile(after_mm, 0.95), both->Statistics().map_points);
    EXPECT_EQ(in_sight_mm.size(), static_cast<std::size_t>(kCovered));
    EXPECT_GE(hidden_mm.size(), 11u);
    EXPECT_GE(carried_mm.size(), 6u);
    EXPECT_GT(both->Statistics().map_points, 100);
    EXPECT_LT(Median(in_sight_mm), 1.2 * Median(alone_mm));
    EXPECT_LT(Median(hidden_mm), 2);
    EXPECT_LT(Median(carried_mm), 2);
    EXPECT_LT(Median(after_mm), 2);
    by_board_mm.push_back(Median(alone_mm));
    open_mm.push_back(Median(in_sight_mm));
    covered_mm.push_back(Median(hidden_mm));
    fog_mm.push_back(Median(carried_mm));
    final_mm.push_back(Median(after_mm));
  }
  std::printf("%zu seeds: board alone %.2f mm / with features %.2f / covered %.2f / fog %.2f / after %.2f\n",
              open_mm.size(), Median(by_board_mm), Median(open_mm), Median(covered_mm), Median(fog_mm),
              Median(final_mm));
}

// A photograph of another camera, four times as many pixels: where it was taken, in the board's frame, by the
// board alone, with the map, and by the map alone where the board is covered.
TEST(Markers, PhotographsAreFoundInTheBoardsFrame) {
  const BesideABoard& scene = Easel();
  SimulationOptions at_full = BesideABoard::OptionsOf(7);
  at_full.width = 1280;
  at_full.height = 960;
  const SimulatedCamera photographer(at_full);
  const auto both = scene.Open("features+markers:"), board = scene.Open("markers:");
  Frame live;
  constexpr int kFrames = 26;
  for (int i = 0; i < kFrames; ++i) {
    live = EaselFrame(i);
    both->Step(live);
  }
  board->Step(live);
  const Rigid3 near = *both->Step(EaselFrame(kFrames)).cam_from_world;
  Frame photograph = photographer.Capture(kFrames + 1);
  const Rigid3 truth = scene.Truth(photograph);
  photograph.known_cam_from_world.reset();
  const auto with_both = both->Locate(photograph, photographer.camera(), near);
  const auto by_board = board->Locate(photograph, photographer.camera(), near);
  ASSERT_TRUE(with_both && by_board);
  const double both_mm = CentreErrorMm(*with_both->cam_from_world, truth),
               board_mm = CentreErrorMm(*by_board->cam_from_world, truth);
  EXPECT_LT(CentreErrorMm(both->PoseOf(*with_both->anchor), truth), both_mm + 1e-6);
  cv::Mat covered = photograph.image.pixels.clone();
  for (int id = 0; id < 12; ++id) {
    const Eigen::Vector3d middle(0.0225 + 0.054 * (id % 3), 0.0225 + 0.054 * (id / 3), 0);
    const auto img = photographer.camera().ImgFromCam(truth * middle);
    ASSERT_TRUE(img);
    cv::circle(covered, {static_cast<int>(img->x()), static_cast<int>(img->y())}, 30, cv::Scalar::all(90),
               -1);
  }
  photograph.image.pixels = covered;
  EXPECT_FALSE(board->Locate(photograph, photographer.camera(), near));
  const auto by_map = both->Locate(photograph, photographer.camera(), near);
  ASSERT_TRUE(by_map);
  const double map_mm = CentreErrorMm(*by_map->cam_from_world, truth);
  std::printf("photograph: board alone %.2f mm, with the map %.2f, by the map alone %.2f\n", board_mm,
              both_mm, map_mm);
  EXPECT_LT(board_mm, 3);
  EXPECT_LT(both_mm, 2.5);
  EXPECT_LT(map_mm, 3);
}

// The board is looked for in the picture as it comes, its corners count in the reduced one that is tracked.
TEST(Markers, TheBoardHelpsReducedPicturesToo) {
  constexpr int kCovered = 34, kEnd = 42;
  const BesideABoard scene(7);
  const auto both =
      PosesSpec::Parse("features+markers:" + scene.standing.board.Text())
          .Open(scene.camera.camera(), {.tracker = {.deterministic = true, .max_side_px = 320}});
  std::vector<double> hidden_mm, in_sight_mm;
  for (int i = 0; i < kEnd; ++i) {
    const bool covered = i >= kCovered;
    const Frame frame = scene.At(i, covered ? BesideABoard::Hidden::kBoard : BesideABoard::Hidden::kNothing);
    const Track track = both->Step(frame);
    if (track.cam_from_world)
      (covered ? hidden_mm : in_sight_mm).push_back(CentreErrorMm(*track.cam_from_world, scene.Truth(frame)));
  }
  std::printf("reduced: in sight %.2f mm, covered %.2f mm\n", Median(in_sight_mm), Median(hidden_mm));
  EXPECT_EQ(both->Statistics().size.width, 320);
  EXPECT_GE(in_sight_mm.size(), 33u);
  EXPECT_GE(hidden_mm.size(), 7u);
  EXPECT_LT(Median(in_sight_mm), 3);
  EXPECT_LT(Median(hidden_mm), 6);
}

// A map that was moved into the board's frame by a similarity that is wrong by 3 % and a degree: the corners
// in its adjustment mend it, and without them it stays wrong.
TEST(Markers, CornersInTheAdjustmentMakeTheMapMetric) {
  const BesideABoard& scene = Easel();
  for (const bool with_corners : {true, false}) {
    Tracker tracker(scene.camera.camera(), {.deterministic = true});
    MarkerLocator locator(scene.camera.camera(), MarkerSpec::Parse(scene.standing.board.Text()));
    BoardFromMap board_from_map;
    constexpr int kEnd = 34;
    std::vector<std::pair<Anchored, Rigid3>> anchors;
    for (int i = 0; i < kEnd; ++i) {
      const Frame& frame = EaselFrame(i);
      const auto pose = locator.Locate(GrayForTracking(frame.image), frame.device_time_s);
      ASSERT_TRUE(pose);
      const FiducialObservation fiducials{pose->corners, pose->cam_from_world, pose->center_sigma};
      const Track track = tracker.Step(frame, with_corners ? std::optional(fiducials) : std::nullopt);
      if (!track.cam_from_world) continue;
      anchors.emplace_back(*track.anchor, scene.Truth(frame));
      board_from_map.Add(*track.anchor, *pose);
      const auto right = board_from_map.Fit(tracker);
      if (!right || tracker.WorldIsGiven()) continue;
      Similarity3 off;
      off.scale = 1.03;
      off.rotation = Eigen::AngleAxisd(M_PI / 180, Eigen::Vector3d::UnitY()).toRotationMatrix();
      tracker.MoveWorld(off * *right);
    }
    ASSERT_GE(anchors.size(), 15u);
    EXPECT_TRUE(tracker.WorldIsGiven());
    tracker.Finish();
    std::vector<double> errors_mm;
    for (const auto& [anchor, truth] : anchors)
      errors_mm.push_back(CentreErrorMm(tracker.PoseOf(anchor), truth));
    std::printf("%s corners: %.2f mm after the run\n", with_corners ? "with" : "without", Median(errors_mm));
    if (with_corners)
      EXPECT_LT(Median(errors_mm), 3);
    else
      EXPECT_GT(Median(errors_mm), 20);
  }
}

// A printed board in a hand, and one of its markers by itself: they agree as well as they say they do.
TEST(Markers, RealBoardIsFound) {
  ULF_NEED_TEST_DATA(data, "aruco_board");
  const CameraModel camera = CameraModel::FromOpenCv(640, 480, 813, 813, 319, 240);
  const MarkerSpec board = MarkerSpec::Parse("aruco:4x5:37.5:5:DICT_6X6_1000");
  const MarkerSpec one = MarkerSpec::Parse("marker:37.5:DICT_6X6_1000:6");
  int posed = 0, alone = 0, wrong = 0, all = 0;
  std::vector<double> rms_px, sigma_mm;
  for (const auto& entry : std::filesystem::directory_iterator(data / "aruco_data")) {
    if (entry.path().extension() != ".jpg") continue;
    ++all;
    const cv::Mat gray = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE);
    const auto whole = MarkerLocator(camera, board).Locate(gray, 0);
    if (!whole) continue;
    ++posed;
    rms_px.push_back(whole->rms_px);
    sigma_mm.push_back(1000 * whole->center_sigma);
    const auto single = MarkerLocator(camera, one).Locate(gray, 0);
    if (!single) continue;
    ++alone;
    const Rigid3 expected = whole->cam_from_world * Rigid3{Eigen::Quaterniond::Identity(),
                                                           {0.0425 * 2 + 0.01875, 0.0425 + 0.01875, 0}};
    wrong += TurnDeg(single->cam_from_world, expected) > 15;
  }
  std::printf("%d of %d photographs posed, %.2f px, sigma %.2f mm; a single marker in %d, wrong in %d\n",
              posed, all, Median(rms_px), Median(sigma_mm), alone, wrong);
  EXPECT_EQ(posed, all);
  EXPECT_GT(all, 40);
  EXPECT_LT(Median(rms_px), 1.2);
  EXPECT_LT(Median(sigma_mm), 4);
  EXPECT_GT(alone, 5);
  EXPECT_EQ(wrong, 0);
}

// Photographs of cubes that all carry tag 0: found where the AprilTag library finds them, and no pose,
// because nobody knows which is which.
TEST(Markers, RealTagsAreFound) {
  ULF_NEED_TEST_DATA(data, "apriltag_photos");
  int matched = 0, files = 0;
  std::vector<double> off_px;
  for (const auto& entry : std::filesystem::directory_iterator(data)) {
    if (entry.path().extension() != ".jpg") continue;
    ++files;
    const cv::Mat gray = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE);
    std::ifstream list(std::filesystem::path(entry.path()).replace_extension(".txt"));
    std::vector<MarkerImage> tags;
    for (std::string line; std::getline(list, line);) {
      MarkerImage t;
      if (std::sscanf(line.c_str(), "0, (%lf %lf), (%lf %lf), (%lf %lf), (%lf %lf)", &t[0].x(), &t[0].y(),
                      &t[1].x(), &t[1].y(), &t[2].x(), &t[2].y(), &t[3].x(), &t[3].y()) == 8)
        tags.push_back(t);
    }
    for (const auto& [id, img] : DetectMarkers("DICT_APRILTAG_36h11", gray)) {
      double nearest = 1e9;
      for (const MarkerImage& tag : tags) {
        double off = 0;
        for (const Eigen::Vector2d& corner : img) {
          double closest = 1e9;
          for (const Eigen::Vector2d& other : tag) closest = std::min(closest, (corner - other).norm());
          off = std::max(off, closest);
        }
        nearest = std::min(nearest, off);
      }
      if (id != 0 || nearest > 5) continue;
      ++matched;
      off_px.push_back(nearest);
    }
    const CameraModel camera = CameraModel::Pinhole(gray.cols, gray.rows, 800);
    EXPECT_FALSE(MarkerLocator(camera, MarkerSpec::Parse("marker:150:DICT_APRILTAG_36h11:0")).Locate(gray, 0))
        << entry.path();
  }
  std::printf("%d of 47 listed tags in %d photographs, worst corner off by %.2f px (median)\n", matched,
              files, Median(off_px));
  EXPECT_EQ(files, 3);
  EXPECT_GE(matched, 18);
  EXPECT_LT(Median(off_px), 2);
}

}  // namespace
}  // namespace ulf::markers_test
