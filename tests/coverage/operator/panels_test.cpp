// Tests: coverage/operator/panels.
//
// What the panels around the live picture say, from staged states; and that the pages list the
// keys of the code.
#include "coverage/operator/panels.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "render/viewer/viewer_state.h"
#include "tests/support/floors.h"
#include "tests/support/staged_capture.h"

namespace ulf::test::panels_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;

std::vector<std::string> Words(const std::vector<StatusItem>& items) {
  std::vector<std::string> words;
  for (const StatusItem& item : items) words.push_back(item.text);
  return words;
}

std::optional<Rgba> ColorOf(const CaptureState& state, const std::string& words) {
  for (const StatusItem& item : StatusLine(state))
    if (item.text.find(words) != std::string::npos) return item.color;
  return std::nullopt;
}

TEST(StatusLine, SaysEveryFigureOfTheSession) {
  StagedCapture stage;
  stage.RecordRows(-5, 5, 0, 0, 5);
  auto state = stage.At(stage.CameraAt(0, 0));
  state->points.resize(412);
  state->covered = 0.4321;
  EXPECT_THAT(Words(StatusLine(*state)), ElementsAre("30 frames/s", "0 dropped", "412 points", "3 views",
                                                     "43.2 % covered", "212 GB left", "exposure locked"));
  state->views_expected = 179.6;
  state->guidance.seconds_left = 61;
  state->frames_per_s = 29.4;
  state->dropped = 7;
  state->disk_left_bytes = 1'640'000'000;
  state->exposure_locked = false;
  state->reopened = {Eigen::Vector3d::UnitX()};
  state->reopened_share = 0.021;
  state->recording = false;
  state->why_waiting = "recording paused: disk full (2.6 MB free, 3.0 needed)";
  EXPECT_THAT(Words(StatusLine(*state)),
              ElementsAre("29 frames/s", "7 dropped", "412 points", "3 views of about 180", "43.2 % covered",
                          "about 65 s left", "1.6 GB left", "exposure not locked", "2 % must be taken again",
                          "paused", "recording paused: disk full (2.6 MB free, 3.0 needed)"));
}

TEST(StatusLine, HasTheMistakesThatAreSeen) {
  const StagedCapture stage({.cap = std::nullopt});
  auto state = stage.At(stage.CameraAt(0, 0));
  state->seconds = 100;
  state->mistakes = {{.mistake = Mistake::kDust, .finding = "", .cure = "", .last_s = 99},
                     {.mistake = Mistake::kFlicker, .finding = "", .cure = "", .last_s = 20}};
  EXPECT_THAT(Words(StatusLine(*state)),
              ::testing::AllOf(::testing::Contains("dust on the lens"),
                               ::testing::Not(::testing::Contains("flickering lamps"))));
}

TEST(StatusLine, OmitsUnknownFigures) {
  const StagedCapture stage({.cap = std::nullopt});
  auto state = stage.At(stage.CameraAt(0, 0));
  state->frames_per_s.reset();
  state->disk_left_bytes.reset();
  state->exposure_locked.reset();
  state->points.clear();
  EXPECT_THAT(Words(StatusLine(*state)), ElementsAre("0 dropped", "0 points", "0 views"));
}

TEST(StatusLine, FaultsStandOut) {
  const StagedCapture stage;
  auto state = stage.At(stage.CameraAt(0, 0));
  EXPECT_EQ(ColorOf(*state, "dropped"), ink::kText);
  EXPECT_EQ(ColorOf(*state, "GB left"), ink::kText);
  EXPECT_EQ(ColorOf(*state, "exposure"), ink::kText);
  state->dropped = 1;
  state->disk_left_bytes = 1'900'000'000;
  state->exposure_locked = false;
  state->recording = false;
  EXPECT_EQ(ColorOf(*state, "dropped"), ink::kCareful);
  EXPECT_EQ(ColorOf(*state, "GB left"), ink::kBad);
  EXPECT_EQ(ColorOf(*state, "exposure"), ink::kCareful);
  EXPECT_EQ(ColorOf(*state, "paused"), ink::kCareful);
}

// A hand that gained a sliver in 20 s once had 29450 minutes left.
TEST(StatusLine, TimeLeftIsRoundedAndCappedAtTenHours) {
  const StagedCapture stage;
  auto state = stage.At(stage.CameraAt(0, 0));
  for (const auto& [seconds, words] : {std::pair{61.0, "about 65 s left"},
                                       {600.0, "about 10 min left"},
                                       {5399.0, "about 90 min left"},
                                       {9000.0, "about 3 h left"},
                                       {29450 * 60.0, "more than 10 h left"}}) {
    state->guidance.seconds_left = seconds;
    EXPECT_THAT(Words(StatusLine(*state)), ::testing::Contains(words));
  }
}

TEST(StatusLine, SaysOneInTheSingular) {
  const StagedCapture stage;
  auto state = stage.At(stage.CameraAt(0, 0));
  state->points.resize(1);
  EXPECT_THAT(Words(StatusLine(*state)), ::testing::Contains("1 point"));
}

// As a session says it: what is waited for names the device's problem once more.
TEST(StatusLine, ADevicesFaultIsSaidOnce) {
  const StagedCapture stage;
  auto state = stage.At(stage.CameraAt(0, 0));
  state->device_problem = "reconnecting: the cable is out";
  state->why_waiting = "waiting for the device, " + state->device_problem;
  const std::vector<std::string> words = Words(StatusLine(*state));
  EXPECT_EQ(std::count_if(words.begin(), words.end(),
                          [](const std::string& text) { return text.find("cable") != std::string::npos; }),
            1);
  EXPECT_EQ(ColorOf(*state, "cable"), ink::kBad);
}

TEST(Legend, NamesWhatIsDrawnAndNothingElse) {
  const Palette& palette = Palette::Standard();
  StagedCapture stage;
  stage.Record(stage.CameraAt(0, 0));
  auto state = stage.At(stage.CameraAt(0, 0));
  const auto words = [&] {
    std::vector<std::string> all;
    for (const LegendMark& mark : LegendMarks(*state, palette)) all.push_back(mark.words);
    return all;
  };
  EXPECT_THAT(words(), ElementsAre("the camera now"));
  state->guidance.toward = Eigen::Vector3d::UnitX();
  state->reopened = {Eigen::Vector3d::UnitX()};
  EXPECT_THAT(words(), ElementsAre("the camera now", "where to go next", "must be taken again"));
  auto passing = std::make_shared<CaptureState>(*state);
  passing->guidance.left_open = {Eigen::Vector3d::UnitX()};
  const LegendMark passed = LegendMarks(*passing, palette)[2];
  EXPECT_EQ(passed.words, "dots: you pass these by");
  EXPECT_EQ(passed.color, palette.guide);
  EXPECT_EQ(LegendMarks(*state, palette)[0].color, palette.camera);
  EXPECT_EQ(LegendMarks(*state, palette)[1].color, palette.guide);
  EXPECT_EQ(LegendMarks(*state, palette)[2].color, palette.reopened);
}

TEST(TrackingTitle, NamesTheStateAndTheWayBack) {
  const StagedCapture stage;
  CaptureState state = *stage.Lost();
  EXPECT_EQ(TrackingTitle(state).title, "LOST");
  EXPECT_EQ(TrackingTitle(state).line, "") << "its turn is not known";
  const Rigid3 then = stage.CameraAt(0, 0), now = stage.CameraAt(0, 0, 1, {0.5, 0});  // aimed to the right
  state.turned = CameraTurn{now.rotation * then.rotation.conjugate(), true};
  EXPECT_EQ(TrackingTitle(state).line, TurnBackInWords(*state.turned));
  EXPECT_THAT(TrackingTitle(state).line, ::testing::HasSubstr("left"));
  state.turned->now_from_reference.setIdentity();
  EXPECT_EQ(TrackingTitle(state).line, "go back to where it was");
  state.tracking = TrackState::kApart;
  EXPECT_EQ(TrackingTitle(state).title, "APART");
  state.tracking = TrackState::kInitializing;
  EXPECT_EQ(TrackingTitle(state).title, "STARTING");
  state.start = StartProgress{.obstacle = StartObstacle::kRotationOnly};
  EXPECT_EQ(TrackingTitle(state).title, "MOVE SIDEWAYS");
  state.start->obstacle = StartObstacle::kLowParallax;
  EXPECT_EQ(TrackingTitle(state).title, "STARTING") << "it moves already";
}

TEST(KeyRows, ListTheKeysOfEveryMode) {
  std::vector<std::string> keys;
  for (const TableRow& row : KeyRows({})) keys.push_back(row.left);
  for (const KeyHelp& help : kKeysAlways) EXPECT_THAT(keys, Contains(help.keys));
  for (const KeyHelp& help : kKeysInSubject) EXPECT_THAT(keys, Contains(help.keys));
  for (const KeyHelp& help : kKeysInReview) EXPECT_THAT(keys, Contains(help.keys));
  EXPECT_THAT(keys, Contains("review"));
}

// The rows of a page's tables below a heading, as far as the next one; without those of dashes.
std::vector<std::vector<std::string>> TableRowsOf(const std::string& page, const std::string& heading) {
  std::ifstream file(std::string(CHECKOUT) + "/docs/" + page);
  std::vector<std::vector<std::string>> rows;
  bool below = heading.empty();
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) below = heading.empty() ? false : line == heading;
    if (!below || !line.starts_with("| ") || line.starts_with("| ---")) continue;
    std::vector<std::string> cells;
    std::istringstream in(line.substr(1));
    for (std::string cell; std::getline(in, cell, '|');) {
      std::erase(cell, '`');
      const std::size_t first = cell.find_first_not_of(' ');
      cells.push_back(
          first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(' ') - first + 1));
    }
    rows.push_back(cells);
  }
  return rows;
}

TEST(KeyTables, OnTheOperatorsPageMatchTheDisplay) {
  std::vector<std::vector<std::string>> expected;
  const auto add = [&](const char* mode, std::span<const KeyHelp> keys) {
    expected.push_back({mode, ""});
    for (const KeyHelp& help : keys) expected.push_back({help.keys, help.what});
  };
  add("always", kKeysAlways);
  add("placing the subject", kKeysInSubject);
  add("review", kKeysInReview);
  EXPECT_EQ(TableRowsOf("capture.md", "## Keys"), expected);
}

// The viewer's page says more of each key, and names keys and mouse apart.
TEST(KeyTables, OnTheViewersPageMatchTheViewer) {
  const auto words = [](const std::string& text) {
    std::set<std::string> words;
    std::string plain = text;
    std::ranges::replace(plain, ',', ' ');
    std::istringstream in(plain);
    for (std::string word; in >> word;)
      if (word != "and") words.insert(word);
    return words;
  };
  std::vector<std::set<std::string>> of_page, of_code;
  for (const auto& row : TableRowsOf("rendering.md", "## Viewer"))
    if (row.size() == 3 && row[0] != "keys") of_page.push_back(words(row[0] + " " + row[1]));
  for (const KeyHelp& help : kViewerKeys) of_code.push_back(words(help.keys));
  EXPECT_EQ(of_page.size(), of_code.size());
  for (const KeyHelp& help : kViewerKeys)
    EXPECT_TRUE(std::ranges::any_of(
        of_page, [&](const auto& row) { return std::ranges::includes(row, words(help.keys)); }))
        << "docs/rendering.md lacks " << help.keys;
  for (const auto& row : of_page)
    EXPECT_TRUE(
        std::ranges::any_of(of_code, [&](const auto& keys) { return std::ranges::includes(row, keys); }))
        << "the viewer lacks " << testing::PrintToString(row);
}

}  // namespace
}  // namespace ulf::test::panels_test
