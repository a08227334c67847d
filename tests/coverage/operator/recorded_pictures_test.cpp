// Tests: coverage/operator/recorded_pictures.
//
// The pictures that review draws from: at hand, read from the light field, bounded, and never of a view that
// is no more.
#include "coverage/operator/recorded_pictures.h"

#include <gmock/gmock.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "core/light_field/folder/light_field_writer.h"
#include "core/light_field/folder/view_images.h"
#include "tests/coverage/session/planar_capture.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"
#include "tests/support/test_paths.h"

namespace ulf::test::recorded_pictures_test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

// Each view has a colour of its own.
cv::Scalar ColourOf(int id) { return {10.0 + 4 * id, 250.0 - 4 * id, 128}; }

// A capture whose views are also on disk, where its writer is still at work.
class Recording {
 public:
  explicit Recording(int views) : writer_(LightFieldWriter::Create(Dir(), Header())) {
    for (int id = 1; id <= views; ++id) Record(true);
  }
  fs::path Dir() const { return scratch_ / "lf"; }
  LightFieldWriter& writer() { return writer_; }
  StagedCapture& capture() { return capture_; }
  // Views stand 3 degrees apart: the nearest is never in doubt.
  Rigid3 PoseOf(int id) const { return capture_.CameraAt(3 * id, 0); }

  std::shared_ptr<CaptureState> Record(bool on_disk) {
    ++last_;
    auto state = Complete(capture_.Record(PoseOf(last_)));
    RecordedFrame view = *state->newest_view;
    view.frame.image = {cv::Mat(120, 160, CV_8UC3, ColourOf(last_)), Transfer::kSrgb};
    state->newest_view = std::make_shared<RecordedFrame>(view);
    if (on_disk) Write(view);
    return state;
  }
  void Write(const RecordedFrame& recorded) {
    View view;
    view.cam_from_world = recorded.cam_from_world;
    ASSERT_EQ(writer_.AddView(recorded.frame, view).id, recorded.id);
  }
  // As a session that has recorded nothing yet shows what is there.
  std::shared_ptr<CaptureState> Resumed() const {
    auto state = Complete(capture_.At(PoseOf(1)));
    state->newest_view.reset();
    return state;
  }

 private:
  CaptureHeader Header() const {
    CaptureHeader header;
    header.camera = capture_.camera();
    return header;
  }
  std::shared_ptr<CaptureState> Complete(std::shared_ptr<CaptureState> state) const {
    state->light_field = Dir();
    return state;
  }

  ScratchFolder scratch_;
  StagedCapture capture_{{.width = 160, .height = 120}};
  LightFieldWriter writer_;
  int last_ = 0;
};

// What is nearest to a view's place once nothing is being read any more.
const PosedPicture* Nearest(RecordedPictures& pictures, const CaptureState& state, const Rigid3& pose) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  for (;;) {
    pictures.Follow(state);
    const auto nearest = pictures.Nearest(state, pose);
    if (pictures.missing() == 0) return nearest.empty() ? nullptr : nearest.front().picture;
    if (std::chrono::steady_clock::now() > until) return nullptr;
    std::this_thread::sleep_for(milliseconds(2));
  }
}

void ExpectShows(const PosedPicture* picture, int id) {
  ASSERT_TRUE(picture) << "view " << id;
  EXPECT_EQ(picture->key, static_cast<std::uint64_t>(id));
  const cv::Scalar mean = cv::mean(picture->Srgb8());
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], ColourOf(id)[c], 2.5) << "view " << id;
}

TEST(RecordedPictures, EarlierViewsAreReadOnDemand) {
  Recording recording(40);
  const auto state = recording.Resumed();
  RecordedPictures pictures;
  pictures.Follow(*state);
  EXPECT_EQ(pictures.size(), 0u) << "nothing is read before it is looked at";
  EXPECT_TRUE(pictures.Nearest(*state, recording.PoseOf(20)).empty()) << "and nobody waits for it";
  EXPECT_EQ(pictures.missing(), 8u);
  for (const int id : {20, 1, 40}) ExpectShows(Nearest(pictures, *state, recording.PoseOf(id)), id);
  EXPECT_LT(pictures.size(), 30u) << "what was not looked at was not read";
  EXPECT_FALSE(pictures.TakeProblem());
}

TEST(RecordedPictures, SkippedStatesLoseNoView) {
  Recording recording(50);
  const auto newest = recording.Record(true);
  CaptureFeed feed;
  for (const auto& state : recording.capture().recorded()) feed.Publish(state);
  feed.Publish(newest);
  RecordedPictures pictures;
  pictures.Follow(*feed.Newest());
  ExpectShows(pictures.Nearest(*newest, recording.PoseOf(51)).front().picture, 51);
  for (int id = 1; id <= 51; id += 10) ExpectShows(Nearest(pictures, *newest, recording.PoseOf(id)), id);
}

TEST(RecordedPictures, SpooledViewIsFoundOnceWritten) {
  Recording recording(3);
  const auto missed = recording.Record(false);
  const auto state = recording.Resumed();
  RecordedPictures pictures;
  const auto until = std::chrono::steady_clock::now() + milliseconds(700);  // longer than between two looks
  while (std::chrono::steady_clock::now() < until) {
    pictures.Follow(*state);
    pictures.Nearest(*state, recording.PoseOf(4));
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(pictures.missing(), 1u);
  EXPECT_EQ(pictures.size(), 3u);
  recording.Write(*missed->newest_view);
  ExpectShows(Nearest(pictures, *state, recording.PoseOf(4)), 4);
  EXPECT_FALSE(pictures.TakeProblem()) << "waiting is no problem";
}

TEST(RecordedPictures, UnreadableViewsAreReportedOnce) {
  Recording recording(6);
  fs::remove(recording.Dir() / "images/000002.png");
  fs::resize_file(recording.Dir() / "images/000005.png", 60);
  const auto state = recording.Resumed();
  RecordedPictures pictures;
  std::vector<std::string> said;
  for (int i = 0; i < 3; ++i)
    for (int id = 1; id <= 6; ++id) {
      const PosedPicture* nearest = Nearest(pictures, *state, recording.PoseOf(id));
      ASSERT_TRUE(nearest);
      if (id != 2 && id != 5)
        ExpectShows(nearest, id);
      else
        EXPECT_NE(nearest->key, static_cast<std::uint64_t>(id));
      while (const auto problem = pictures.TakeProblem()) said.push_back(*problem);
    }
  EXPECT_THAT(said, UnorderedElementsAre(AllOf(HasSubstr("000002.png"), HasSubstr("leaves out view 2")),
                                         AllOf(HasSubstr("000005.png"), HasSubstr("leaves out view 5"))));
}

TEST(RecordedPictures, AFolderThatIsGoneIsSaidOnce) {
  Recording recording(3);
  auto state = recording.Record(true);
  state->light_field = "/nowhere/at/all";
  RecordedPictures pictures;
  std::vector<std::string> said;
  const auto until = std::chrono::steady_clock::now() + milliseconds(1200);  // two looks at the journal
  while (std::chrono::steady_clock::now() < until) {
    pictures.Follow(*state);
    ExpectShows(pictures.Nearest(*state, recording.PoseOf(4)).front().picture, 4);
    if (const auto problem = pictures.TakeProblem()) said.push_back(*problem);
    std::this_thread::sleep_for(milliseconds(10));
  }
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], HasSubstr("/nowhere/at/all/journal.jsonl"));
}

TEST(RecordedPictures, StayInBudgetAndReloadFromDisk) {
  Recording recording(0);
  constexpr std::size_t kBudget = 12'000;
  RecordedPictures pictures(kBudget);
  std::shared_ptr<CaptureState> state;
  for (int i = 0; i < 60; ++i) {
    state = recording.Record(true);
    pictures.Follow(*state);
    EXPECT_LE(pictures.bytes(), kBudget);
  }
  EXPECT_GE(pictures.size(), 9u) << "the budget holds what is drawn and read ahead";
  EXPECT_LT(pictures.size(), 40u) << "or nothing was dropped";
  for (const int id : {1, 60, 30, 2}) {
    ExpectShows(Nearest(pictures, *state, recording.PoseOf(id)), id);
    EXPECT_LE(pictures.bytes(), kBudget);
  }
}

TEST(RecordedPictures, TakenBackViewsAreGoneAtOnce) {
  Recording recording(0);
  RecordedPictures pictures;
  for (int i = 0; i < 5; ++i) pictures.Follow(*recording.Record(true));
  EXPECT_EQ(pictures.size(), 5u);
  const std::size_t bytes = pictures.bytes();
  recording.capture().TakeBack(5);
  recording.capture().TakeBack(2);
  auto state = recording.capture().At(recording.PoseOf(1));
  state->light_field = recording.Dir();
  pictures.Follow(*state);
  EXPECT_EQ(pictures.size(), 3u);
  EXPECT_LT(pictures.bytes(), 0.7 * static_cast<double>(bytes));
  for (int id = 1; id <= 5; ++id) {
    const auto nearest = pictures.Nearest(*state, recording.PoseOf(id));
    for (const WeightedPicture& picture : nearest)
      EXPECT_TRUE(picture.picture->key != 5 && picture.picture->key != 2);
  }
  EXPECT_EQ(pictures.missing(), 0u);
}

TEST(RecordedPictures, ViewMayBeTakenBackWhileWanted) {
  Recording recording(20);
  const auto state = recording.Resumed();
  RecordedPictures pictures;
  ExpectShows(Nearest(pictures, *state, recording.PoseOf(1)), 1);
  recording.writer().RemoveViews({20});  // neither the state nor who reads knows yet
  ExpectShows(Nearest(pictures, *state, recording.PoseOf(20)), 19);
  EXPECT_FALSE(pictures.TakeProblem());
}

TEST(RecordedPictures, StandWhereTheCapturesPosesAreNow) {
  Recording recording(0);
  RecordedPictures pictures;
  auto state = recording.Record(true);
  pictures.Follow(*state);
  const Rigid3 corrected = recording.capture().CameraAt(5, 1, 1.1);
  const std::vector<CriterionView> moved{CriterionView::From(state->camera, corrected, 640)};
  state->coverage =
      std::make_shared<CoverageMap>(state->coverage->subject(), state->coverage->options(), moved);
  const auto nearest = pictures.Nearest(*state, corrected);
  ASSERT_EQ(nearest.size(), 1u);
  const Rigid3& pose = nearest[0].picture->cam_from_world;
  EXPECT_LT((pose.OriginInSource() - corrected.OriginInSource()).norm(), 1e-9);
  EXPECT_LT(RotationAngle(pose.rotation * corrected.rotation.conjugate()), 1e-6);
}

// The whole way: a capture that goes on with a light field, and what can be seen of it meanwhile.
TEST(RecordedPictures, ResumedCaptureShowsEarlierViews) {
  const ScratchFolder scratch;
  std::vector<PlanarShot> before, after;
  for (int i = 0; i < 6; ++i) before.push_back({PoseAt(3.0 * i, 0)});
  for (int i = 6; i < 10; ++i) after.push_back({PoseAt(3.0 * i, 0)});
  ASSERT_EQ(Capture(scratch / "lf", before).light_field.views.size(), 6u);
  RecordedPictures pictures;
  SharedCaptureState last;
  CaptureHooks hooks;
  hooks.after_frame = [&](const SharedCaptureState& now) {
    EXPECT_GE(now->view_ids.size(), 7u) << "all of them, from the first state on";
    last = now;
    pictures.Follow(*now);
  };
  const Captured resumed = Capture(scratch / "lf", after, Options(), {}, hooks);
  ASSERT_EQ(resumed.light_field.views.size(), 10u);
  for (const View& view : resumed.light_field.views) {
    const PosedPicture* nearest = Nearest(pictures, *last, view.cam_from_world);
    ASSERT_TRUE(nearest);
    EXPECT_EQ(nearest->key, static_cast<std::uint64_t>(view.id));
    EXPECT_GT(cv::PSNR(nearest->Srgb8(), ReadRecordedImage(resumed.light_field, view).pixels), 30)
        << "view " << view.id;
  }
}

}  // namespace
}  // namespace ulf::test::recorded_pictures_test
