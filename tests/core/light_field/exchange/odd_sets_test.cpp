// Tests: core/light_field/exchange/import_light_field, core/light_field/exchange/subject_of_set,
// core/light_field/exchange/read_posed_set, core/light_field/formats/posed_set.
//
// Sets that are hardly any, or whose numbers are wrong, in several formats: imported right, or refused with
// what is wrong and nothing left behind.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/image/files/png_picture.h"
#include "core/light_field/exchange/import_light_field.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"

namespace ulf::odd_sets_test {
namespace {

using Eigen::Vector3d;
using test::ScratchFolder;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

enum class Carrier { kTransforms, kColmapText, kColmapBinary };

Rigid3 LooksAtMiddle(const Vector3d& from) { return LookAt(from, Vector3d::Zero(), -Vector3d::UnitY()); }
Rigid3 LooksAhead(const Vector3d& from) { return LookAt(from, from + Vector3d::UnitZ(), -Vector3d::UnitY()); }

std::vector<Rigid3> Repeated(int count, const std::function<Rigid3(int)>& pose) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) poses.push_back(pose(i));
  return poses;
}

Rigid3 WithCenter(const Vector3d& center) { return {Eigen::Quaterniond::Identity(), -center}; }

struct OddSet {
  const char* name;
  std::vector<Rigid3> cam_from_world;
  const char* refused;  // what the refusal says; null: all views are imported
  bool has_points = false;
};

std::vector<OddSet> OddSets() {
  const auto ring = [](int i) {
    return LooksAtMiddle({3 * std::sin(0.4 * i), 0.2 * i, -3 * std::cos(0.4 * i)});
  };
  std::vector<Rigid3> twice = Repeated(6, ring), apart = Repeated(3, ring), joined = Repeated(6, ring);
  twice[3] = twice[2];
  for (int i = 0; i < 3; ++i) {
    Rigid3 moved = ring(i);
    moved.translation += moved.rotation * Vector3d(-500, 0, 0);
    apart.push_back(moved);
  }
  joined[4] = WithCenter({kNan, 0, 0});
  std::vector<Rigid3> endless = Repeated(6, ring);
  endless[4] = WithCenter({std::numeric_limits<double>::infinity(), 0, 0});
  return {
      {"one image", Repeated(1, ring), "one photograph alone"},
      {"two images of one thing", Repeated(2, ring), nullptr},
      {"two images side by side",
       Repeated(2,
                [](int i) {
                  return LooksAhead({0.2 * i, 0, 0});
                }),
       "nearly parallel"},
      {"identical poses", Repeated(5, [&](int) { return ring(1); }), "all cameras stand at one place"},
      {"two identical poses among others", twice, nullptr},
      {"cameras that turn on one spot",
       Repeated(8,
                [](int i) {
                  return LookAt({1, 2, 3},
                                Vector3d(1, 2, 3) + Vector3d(std::sin(0.5 * i), 0, std::cos(0.5 * i)),
                                -Vector3d::UnitY());
                }),
       "do without one (no_subject)"},
      {"two clusters", apart, "two groups far apart"},
      {"a straight line past one thing",
       Repeated(7,
                [](int i) {
                  return LooksAtMiddle({0.5 * i - 1.5, 0, -3});
                }),
       nullptr},
      {"a straight line ahead",
       Repeated(7,
                [](int i) {
                  return LooksAhead({0, 0, 0.3 * i});
                }),
       "nearly parallel"},
      {"a straight line ahead, with points",
       Repeated(7,
                [](int i) {
                  return LooksAhead({0, 0, 0.1 * i - 3});
                }),
       nullptr, true},
      {"a ring that looks outwards",
       Repeated(8,
                [](int i) {
                  return LookAt(Vector3d(std::sin(0.785 * i), 0, std::cos(0.785 * i)),
                                2 * Vector3d(std::sin(0.785 * i), 0, std::cos(0.785 * i)),
                                -Vector3d::UnitY());
                }),
       "meet behind the cameras"},
      {"a centre that is no number", joined, "4"},
      {"a centre without end", endless, "4"},
  };
}

void WriteTransforms(const LightField& set) {
  nlohmann::json document = TransformsDocument(set);
  document.erase("ulf");
  for (nlohmann::json& frame : document["frames"]) frame.erase("ulf");
  if (!set.points.empty()) document["ply_file_path"] = "points.ply";
  WriteFileAtomically(set.root / kTransformsFile, document.dump());  // a number that JSON lacks becomes null
  if (set.points.empty()) return;
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "end_header\n",
      set.points.size());
  for (const ScenePoint& point : set.points)
    ply += fmt::format("{} {} {}\n", point.position_in_world.x(), point.position_in_world.y(),
                       point.position_in_world.z());
  WriteFileAtomically(set.root / "points.ply", ply);
}

void WriteSet(const OddSet& odd, Carrier carrier, const fs::path& folder) {
  LightField set;
  set.root = folder;
  set.cameras = {CameraModel::Pinhole(kWidth, kHeight, 60)};
  fs::create_directories(folder / "images");
  for (std::size_t i = 0; i < odd.cam_from_world.size(); ++i) {
    View& view = set.views.emplace_back();
    view.id = static_cast<int>(i) + 1;
    view.image_path = fmt::format("images/shot{}.png", i);
    view.cam_from_world = odd.cam_from_world[i];
    WriteFileAtomically(folder / view.image_path, PngBytes(NoiseFrame(static_cast<int>(i)).image.pixels));
  }
  for (int i = 0; odd.has_points && i < 60; ++i) {
    ScenePoint& point = set.points.emplace_back();
    point.position_in_world = {0.4 * std::sin(i), 0.3 * std::cos(1.7 * i), 0.3 * std::sin(2.3 * i)};
    for (const View& view : set.views)
      if (const auto img = set.cameras[0].ImgFromCam(view.cam_from_world * point.position_in_world);
          img && set.cameras[0].Contains(*img))
        point.track.push_back({view.id, *img});
  }
  if (carrier == Carrier::kTransforms) return WriteTransforms(set);
  fs::create_directories(folder / "sparse/0");
  const bool binary = carrier == Carrier::kColmapBinary;
  const ColmapReconstruction model = ToColmap(set);
  const ColmapFiles files = binary ? ToColmapBinary(model) : ToColmapText(model);
  const std::string ending = binary ? ".bin" : ".txt";
  WriteFileAtomically(folder / ("sparse/0/cameras" + ending), files.cameras);
  WriteFileAtomically(folder / ("sparse/0/images" + ending), files.images);
  WriteFileAtomically(folder / ("sparse/0/points3D" + ending), files.points3d);
}

// Returns what the import says when it refuses; empty if it takes all views in.
std::string RefusalOf(const fs::path& set, const fs::path& dir, std::size_t views,
                      const ImportOptions& options) {
  try {
    const Imported imported = Import(set, dir, options);
    EXPECT_EQ(imported.light_field.views.size(), views);
    fs::remove_all(dir);
    return {};
  } catch (const Error& error) {
    EXPECT_FALSE(fs::exists(dir)) << error.what();
    return error.what();
  }
}

class OddSetsIn : public testing::TestWithParam<Carrier> {};

TEST_P(OddSetsIn, AreImportedRightOrNamed) {
  for (const OddSet& odd : OddSets()) {
    SCOPED_TRACE(odd.name);
    const ScratchFolder scratch;
    WriteSet(odd, GetParam(), scratch / "set");
    const std::size_t views = odd.cam_from_world.size();
    const std::string refusal = RefusalOf(scratch / "set", scratch / "lf", views, {});
    if (!odd.refused) {
      EXPECT_EQ(refusal, "");
      continue;
    }
    const bool is_finite = std::ranges::all_of(
        odd.cam_from_world, [](const Rigid3& pose) { return pose.translation.allFinite(); });
    const bool has_lines = !is_finite && GetParam() == Carrier::kColmapText;
    EXPECT_THAT(refusal, HasSubstr(has_lines ? "images.txt, line" : odd.refused));
    if (!is_finite) continue;
    // Every way out that the refusal names leads out.
    EXPECT_THAT(refusal, HasSubstr(Parameter("no_subject")));
    EXPECT_EQ(RefusalOf(scratch / "set", scratch / "lf", views, {.without_subject = true}), "");
    EXPECT_THAT(refusal, HasSubstr(Parameter("subject") + " x,y,z,radius"));
    EXPECT_EQ(RefusalOf(scratch / "set", scratch / "lf", views, {.subject = Subject{{0, 0, 9}, 1}}), "");
  }
}

INSTANTIATE_TEST_SUITE_P(All, OddSetsIn,
                         testing::Values(Carrier::kTransforms, Carrier::kColmapText, Carrier::kColmapBinary));

}  // namespace
}  // namespace ulf::odd_sets_test
