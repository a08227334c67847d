// Tests: core/light_field/exchange/poses_of_set, core/light_field/formats/transforms_json.
//
// Camera paths of sets whose photographs are gone.
#include "core/light_field/exchange/poses_of_set.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/json_text.h"
#include "core/light_field/exchange/writers/set_writers.h"
#include "core/light_field/formats/colmap_files.h"
#include "core/light_field/formats/transforms_json.h"
#include "tests/core/light_field/light_field_samples.h"
#include "tests/support/test_paths.h"

namespace ulf::poses_of_set_test {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kViews = 5;

json WithoutOurs(const LightField& sample) {
  json document = TransformsDocument(sample);
  document.erase("ulf");
  for (json& frame : document["frames"]) frame.erase("ulf");
  return document;
}

void WriteJson(const fs::path& file, const json& document) { std::ofstream(file) << JsonText(document); }

void WriteModel(const fs::path& folder, const ColmapFiles& files, const std::string& ending) {
  fs::create_directories(folder);
  WriteFileAtomically(folder / ("cameras" + ending), files.cameras);
  WriteFileAtomically(folder / ("images" + ending), files.images);
}

// How a set of the sample's poses lies on the disk, without a photograph; what is given as path, in it.
struct Layout {
  std::string name;
  std::function<void(const LightField& sample, const fs::path& set)> write;
  std::string given = {};
};

std::vector<Layout> Layouts() {
  return {
      {"a light field",
       [](const LightField& sample, const fs::path& set) {
         fs::copy(sample.root / kJournalFile, set / kJournalFile);
       }},
      {"its transforms.json",
       [](const LightField& sample, const fs::path& set) {
         fs::copy(sample.root / kTransformsFile, set / kTransformsFile);
       }},
      {"transforms.json of another program",
       [](const LightField& sample, const fs::path& set) {
         WriteJson(set / kTransformsFile, WithoutOurs(sample));
       }},
      {"that file itself, under another name",
       [](const LightField& sample, const fs::path& set) {
         WriteJson(set / "path.json", WithoutOurs(sample));
       },
       "path.json"},
      {"NeRF's synthetic parts",
       [](const LightField& sample, const fs::path& set) {
         json train = WithoutOurs(sample), test = train;
         train["frames"].erase(train["frames"].begin() + 3, train["frames"].end());
         test["frames"].erase(test["frames"].begin(), test["frames"].begin() + 3);
         WriteJson(set / "transforms_train.json", train);
         WriteJson(set / "transforms_test.json", test);
       }},
      {"COLMAP, text",
       [](const LightField& sample, const fs::path& set) {
         WriteModel(set / "sparse/0", ToColmapText(ToColmap(sample)), ".txt");
       }},
      {"COLMAP, binary, the model's folder",
       [](const LightField& sample, const fs::path& set) {
         WriteModel(set / "model", ToColmapBinary(ToColmap(sample)), ".bin");
       },
       "model"},
  };
}

TEST(PosesOfSet, NeedNoPhotographs) {
  for (const Layout& layout : Layouts()) {
    const ScratchFolder scratch;
    const LightField sample = WriteSample(scratch / "lf", kViews);
    fs::create_directories(scratch / "set");
    layout.write(sample, scratch / "set");
    const SetPoses poses = ReadPosesOfSet(scratch.path() / "set" / layout.given);
    ASSERT_EQ(poses.cam_from_world.size(), std::size_t{kViews}) << layout.name;
    ASSERT_EQ(poses.cameras.size(), std::size_t{kViews}) << layout.name;
    for (std::size_t i = 0; i < kViews; ++i) {
      EXPECT_LT((poses.cam_from_world[i].Matrix() - sample.views[i].cam_from_world.Matrix()).norm(), 1e-9)
          << layout.name << ", view " << i;
      EXPECT_EQ(poses.cameras[i], sample.CameraOf(sample.views[i])) << layout.name;
    }
  }
}

// Where coordinates have another origin cameras agree but for rounding.
void ExpectThePosesOf(const LightField& sample, const SetPoses& poses) {
  ASSERT_EQ(poses.cam_from_world.size(), sample.views.size());
  ASSERT_EQ(poses.cameras.size(), sample.views.size());
  for (std::size_t i = 0; i < sample.views.size(); ++i) {
    EXPECT_LT((poses.cam_from_world[i].Matrix() - sample.views[i].cam_from_world.Matrix()).norm(), 1e-9);
    const Eigen::Vector3d seen(0.2, -0.1, 1);
    EXPECT_LT(
        (*poses.cameras[i].ImgFromCam(seen) - *sample.CameraOf(sample.views[i]).ImgFromCam(seen)).norm(),
        1e-9);
  }
}

TEST(PosesOfSet, OtherProgramsFilesNeedNoneEither) {
  const ScratchFolder scratch;
  LightField sample = WriteSample(scratch / "lf", kViews);
  WriteFileAtomically(scratch / "cameras.xml", MetashapeXmlText(sample));
  ExpectThePosesOf(sample, ReadPosesOfSet(scratch / "cameras.xml"));
  // Inria's file has pinholes, and the rotation from camera to world.
  sample.cameras = {CameraModel::Pinhole(kWidth, kHeight, 60)};
  json cameras = json::array();
  for (const View& view : sample.views) {
    const Eigen::Matrix4d m = view.cam_from_world.Inverse().Matrix();
    json rotation = json::array();
    for (int r = 0; r < 3; ++r) rotation.push_back({m(r, 0), m(r, 1), m(r, 2)});
    cameras.push_back({{"img_name", view.image_path},
                       {"width", kWidth},
                       {"height", kHeight},
                       {"position", {m(0, 3), m(1, 3), m(2, 3)}},
                       {"rotation", rotation},
                       {"fx", 60},
                       {"fy", 60}});
  }
  WriteJson(scratch / "cameras.json", cameras);
  ExpectThePosesOf(sample, ReadPosesOfSet(scratch / "cameras.json"));
}

// NeRF's original files say a field of view, and of pictures that are not there nothing else.
TEST(PosesOfSet, HaveNoCamerasWhereNoSizeIsTold) {
  const ScratchFolder scratch;
  json document = WithoutOurs(WriteSample(scratch / "lf", kViews));
  const json frames = document["frames"];
  document = {{"camera_angle_x", 0.7}, {"frames", frames}};
  WriteJson(scratch / "transforms.json", document);
  const SetPoses poses = ReadPosesOfSet(scratch / "transforms.json");
  EXPECT_EQ(poses.cam_from_world.size(), std::size_t{kViews});
  EXPECT_TRUE(poses.cameras.empty());
}

TEST(PosesOfSet, FaultsAreNamed) {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "empty");
  EXPECT_THAT([&] { ReadPosesOfSet(scratch / "empty"); },
              ThrowsMessage<Error>(HasSubstr("holds no light field")));
  json document = WithoutOurs(WriteSample(scratch / "lf", kViews));
  document["frames"][2]["transform_matrix"][0][0] = 7;
  WriteJson(scratch / "path.json", document);
  EXPECT_THAT([&] { ReadPosesOfSet(scratch / "path.json"); },
              ThrowsMessage<Error>(AllOf(HasSubstr("frame 2"), HasSubstr("not a rotation"))));
}

}  // namespace
}  // namespace ulf::poses_of_set_test
