// Tests: tracking/refine/pose_check, tracking/refine/obstructed_views.
//
// Sets of photographs whose poses are good, with every tenth pose made wrong: what is found, and what is
// blamed that is right. Prints a row of the table in docs/measured/tracking.md for each set.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/opening/open_device.h"
#include "core/base/quantile.h"
#include "core/geometry/trajectory.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/exchange/read_posed_set.h"
#include "core/light_field/folder/view_images.h"
#include "tests/support/drawn_hand.h"
#include "tests/support/floors.h"
#include "tests/support/pose_readers.h"
#include "tests/support/test_paths.h"
#include "tests/tracking/refine/refine_views.h"
#include "tracking/refine/pose_check.h"
#include "tracking/refine/refine_input.h"

namespace ulf::pose_check_long_test {
namespace {

namespace fs = std::filesystem;

struct PosedPictures {
  std::string name;
  RefineInput input;
  double distance = 0;  // from the cameras to where their axes meet, median
};

PosedPictures WithDistance(PosedPictures pictures) {
  LightField axes;
  axes.cameras = pictures.input.lenses;
  for (const RefineInput::View& posed : pictures.input.views) {
    View& view = axes.views.emplace_back();
    view.camera = posed.lens;
    view.cam_from_world = posed.cam_from_world;
  }
  std::vector<double> distances;
  if (const auto subject = SubjectFromAxes(axes))
    for (const View& view : axes.views)
      distances.push_back((view.CenterInWorld() - subject->center_in_world).norm());
  pictures.distance = Median(std::move(distances));
  return pictures;
}

std::function<Image(int)> ReaderOf(std::vector<fs::path> files) {
  return [files = std::move(files)](int i) {
    return Image{ReadImageFile(files[static_cast<std::size_t>(i)].string()), Transfer::kSrgb, Mosaic::kNone};
  };
}

PosedPictures OfTrueViews(const std::string& name, const std::vector<test::TrueView>& views) {
  PosedPictures pictures{name, {}, 0};
  std::vector<fs::path> files;
  for (const test::TrueView& view : views) {
    pictures.input.lenses.push_back(view.camera);
    pictures.input.views.push_back(
        {view.image.filename().string(), static_cast<int>(files.size()), view.cam_from_world});
    files.push_back(view.image);
  }
  pictures.input.read = ReaderOf(std::move(files));
  return WithDistance(std::move(pictures));
}

// Frames of a sequence of 30 a second that have a pose in a TUM file, every `step`th of them.
PosedPictures OfSequence(const fs::path& folder, const std::string& truth, const std::string& file,
                         std::size_t step) {
  PosedPictures pictures{folder.filename().string(), {}, 0};
  pictures.input.lenses = {ReadCalibration((folder / "intrinsics.txt").string())};
  const std::vector<TimedPose> poses = ReadTum((folder / truth).string());
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < poses.size(); i += step) {
    files.push_back(folder / fmt::format(fmt::runtime(file), std::lround(30 * poses[i].time_s)));
    pictures.input.views.push_back({files.back().filename().string(), 0, poses[i].cam_from_world});
  }
  pictures.input.read = ReaderOf(std::move(files));
  return WithDistance(std::move(pictures));
}

// A set as others write it, read where it is.
PosedPictures OfSet(const fs::path& folder) {
  const auto light_field = std::make_shared<LightField>(ReadPosedSet(folder, std::nullopt, {}).light_field);
  PosedPictures pictures{folder.filename().string(), tracking::RefineInputOf(*light_field), 0};
  pictures.input.read = [light_field](int i) {
    return ReadRecordedImage(*light_field, light_field->views[static_cast<std::size_t>(i)]);
  };
  return WithDistance(std::move(pictures));
}

PosedPictures OfSimulator(const std::string& scene, unsigned seed, int views, int step) {
  const auto device = OpenDevice(fmt::format("sim:{}?seed={}&row_deg=4&look_away=0", scene, seed));
  device->Start();
  PosedPictures pictures{fmt::format("sim:{}, seed {}", scene, seed), {}, 0};
  pictures.input.lenses = {*device->Camera()};
  const auto images = std::make_shared<std::vector<Image>>();
  for (int k = 0; k < views * step; ++k) {
    const auto frame = device->Next(std::chrono::seconds(10));
    if (!frame || k % step != 0) continue;
    pictures.input.views.push_back({fmt::format("frame {}", k), 0, *frame->known_cam_from_world});
    images->push_back(frame->image);
  }
  pictures.input.read = [images](int i) { return (*images)[static_cast<std::size_t>(i)]; };
  return WithDistance(std::move(pictures));
}

struct Found {
  int wrong = 0, found = 0, blamed = 0, not_judged = 0;
};

Found Compare(const PoseCheck& check, const std::set<int>& wrong) {
  Found found{static_cast<int>(wrong.size()), 0, 0, static_cast<int>(check.undecided.size())};
  for (const tracking::ContradictedView& view : check.contradicted)
    ++(wrong.contains(view.view) ? found.found : found.blamed);
  return found;
}

std::string InWords(const Found& found) {
  return fmt::format("{} of {}{}{}", found.found, found.wrong,
                     found.blamed > 0 ? fmt::format(", {} blamed", found.blamed) : "",
                     found.not_judged > 0 ? fmt::format(", {} not judged", found.not_judged) : "");
}

// Every tenth view is made wrong; a swap needs two of them.
void ExpectFound(const PosedPictures& pictures) {
  ASSERT_GT(pictures.distance, 0) << pictures.name;
  std::set<int> tenth;
  for (int v = std::min(5, static_cast<int>(pictures.input.views.size()) / 2);
       v < static_cast<int>(pictures.input.views.size()); v += 10)
    tenth.insert(v);
  const auto start = std::chrono::steady_clock::now();
  const PoseCheck right = CheckPoses(pictures.input);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_EQ(right.contradicted.size(), 0u) << pictures.name;
  std::string row = fmt::format("| {} | {} | {:.2f} px | {}", pictures.name, pictures.input.views.size(),
                                right.error_px, right.contradicted.size());
  if (!right.undecided.empty()) row += fmt::format(", {} not judged", right.undecided.size());
  for (const auto& [shift, angle_deg] : {std::pair(0.03, 0.0), std::pair(0.0, 2.0)}) {
    PosedPictures off = pictures;
    test::Draw draw(7);
    for (const int v : tenth) {
      Rigid3& pose = off.input.views[static_cast<std::size_t>(v)].cam_from_world;
      pose = test::Disturbed(pose, shift * pictures.distance, angle_deg, draw);
    }
    const PoseCheck check = CheckPoses(off.input);
    const Found found = Compare(check, tenth);
    row += " | " + InWords(found);
    EXPECT_EQ(found.found, found.wrong) << pictures.name << ", " << shift << ", " << angle_deg << " degrees";
    EXPECT_EQ(found.blamed, 0) << pictures.name << ", " << shift << ", " << angle_deg << " degrees";
  }
  PosedPictures swapped = pictures;
  const std::vector<int> order(tenth.begin(), tenth.end());
  std::set<int> exchanged;
  for (std::size_t i = 0; i + 1 < order.size(); i += 2) {
    std::swap(swapped.input.views[static_cast<std::size_t>(order[i])].cam_from_world,
              swapped.input.views[static_cast<std::size_t>(order[i + 1])].cam_from_world);
    exchanged.insert({order[i], order[i + 1]});
  }
  const Found found = Compare(CheckPoses(swapped.input), exchanged);
  EXPECT_EQ(found.blamed, 0) << pictures.name << ", swapped";
  fmt::print("{} | {} | {:.1f} s |\n", row, exchanged.empty() ? "" : InWords(found), seconds);
}

// Hands are drawn before every tenth view, of this share of the picture. Prints a row of the table of views
// through a hand.
void ExpectHandsNamed(const PosedPictures& pictures) {
  const std::size_t without = CheckPoses(pictures.input).obstructed.size();
  std::string row = fmt::format("| {} | {} | {}", pictures.name, pictures.input.views.size(), without);
  EXPECT_EQ(without, 0u) << pictures.name;
  int all = 0, all_found = 0;
  for (const double share : {0.2, 0.45, 0.7, 0.9}) {
    std::set<int> hands;
    for (int v = std::min(5, static_cast<int>(pictures.input.views.size()) / 2);
         v < static_cast<int>(pictures.input.views.size()); v += 10)
      hands.insert(v);
    PosedPictures covered = pictures;
    covered.input.read = [&](int i) {
      Image image = pictures.input.read(i);
      if (!hands.contains(i)) return image;
      image.pixels = image.pixels.clone();
      const auto look = static_cast<test::HandLook>(i / 10 % 3);
      test::DrawHand(image.pixels, share, look, static_cast<unsigned>(i) + 1);
      return image;
    };
    int found = 0, blamed = 0;
    for (const tracking::ObstructedView& view : CheckPoses(covered.input).obstructed)
      ++(hands.contains(view.view) ? found : blamed);
    row += fmt::format(" | {} of {}", found, hands.size());
    if (blamed > 0) row += fmt::format(", {} blamed", blamed);
    all += static_cast<int>(hands.size());
    all_found += found;
    EXPECT_EQ(blamed, 0) << pictures.name << ", " << share;
  }
  // Hands are missed where neighbours show nothing behind them, and where they leave nothing to compare.
  EXPECT_GE(all_found, 0.7 * all) << pictures.name;
  fmt::print("{} |\n", row);
}

using Expectation = void (*)(const PosedPictures&);

void InFern(Expectation expect) {
  ULF_NEED_TEST_DATA(folder, "llff_fern");
  expect(OfSet(folder));
}

void InTempleRing(Expectation expect) {
  ULF_NEED_TEST_DATA(folder, "temple_ring");
  expect(OfTrueViews("temple_ring", test::ReadMiddlebury(folder, "templeR_par.txt")));
}

void InFox(Expectation expect) {
  ULF_NEED_TEST_DATA(folder, "fox_half");
  expect(OfSet(folder));
}

void InTheKitchen(Expectation expect) {
  ULF_NEED_TEST_DATA(folder, "handheld_kitchen");
  PosedPictures pictures = OfSequence(folder, "colmap_reference.txt", "frame-{:06}.color.jpg", 1);
  pictures.distance = 2;  // metres, by its depth images: a walk whose axes meet nowhere
  expect(pictures);
}

void InStrecha(Expectation expect) {
  ULF_NEED_TEST_DATA(folder, "strecha");
  for (const char* name : {"fountain-P11", "Herz-Jesus-P8"})
    expect(OfTrueViews(name, test::ReadStrecha(folder / name)));
}

TEST(PoseCheckData, NamesHandsOfTheSimulator) {
  for (const unsigned seed : {1u, 2u}) ExpectHandsNamed(OfSimulator("studio", seed, 40, 8));
  ExpectHandsNamed(OfSimulator("room", 3, 40, 8));
  ExpectHandsNamed(OfSimulator("gloss", 4, 40, 8));
}

TEST(PoseCheckData, NamesHandsInFern) { InFern(ExpectHandsNamed); }

TEST(PoseCheckData, NamesHandsInTempleRing) { InTempleRing(ExpectHandsNamed); }

TEST(PoseCheckData, NamesHandsInFox) { InFox(ExpectHandsNamed); }

TEST(PoseCheckData, NamesHandsInTheKitchen) { InTheKitchen(ExpectHandsNamed); }

TEST(PoseCheckData, NamesHandsInStrecha) { InStrecha(ExpectHandsNamed); }

TEST(PoseCheckData, FindsEveryWrongPoseOfTheSimulator) {
  for (const unsigned seed : {1u, 2u}) ExpectFound(OfSimulator("studio", seed, 50, 6));
  ExpectFound(OfSimulator("room", 3, 50, 6));
}

TEST(PoseCheckData, FindsEveryWrongPoseOfFern) { InFern(ExpectFound); }

TEST(PoseCheckData, FindsEveryWrongPoseOfTempleRing) { InTempleRing(ExpectFound); }

TEST(PoseCheckData, FindsEveryWrongPoseOfFox) { InFox(ExpectFound); }

TEST(PoseCheckData, FindsEveryWrongPoseOfTheKitchen) { InTheKitchen(ExpectFound); }

TEST(PoseCheckData, FindsEveryWrongPoseOfAScan) {
  ULF_NEED_TEST_DATA(folder, "scan_synthetic");
  ExpectFound(OfSequence(folder, "groundtruth.txt", "{:06}.jpg", 10));
}

TEST(PoseCheckData, FindsEveryWrongPoseOfStrecha) { InStrecha(ExpectFound); }

}  // namespace
}  // namespace ulf::pose_check_long_test
