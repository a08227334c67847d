// Tests: core/light_field/exchange/writers/colmap_folder, core/light_field/exchange/writers/colmap_program,
// core/light_field/formats/colmap_rigs, core/light_field/formats/colmap_model.
//
// An export for COLMAP and the commands beside it, by the rules of COLMAP 4: what Reconstruction::Load()
// (src/colmap/scene/reconstruction.cc) compares between a model and the database that the commands make.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/light_field/exchange/export_light_field.h"
#include "tests/core/light_field/reader_rules.h"
#include "tests/core/light_field/tracked_light_field.h"
#include "tests/support/test_paths.h"

namespace ulf::colmap_folder_test {
namespace {

namespace fs = std::filesystem;
using test::ColmapRead;
using test::ScratchFolder;
using test::TrackedLightField;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// The database of feature_extractor (src/colmap/controllers/image_reader.cc, feature_extraction.cc): image,
// frame, camera and rig get the next number as they come.
struct Database {
  std::map<std::string, long> images, camera_of;  // by name
  std::map<long, std::string> models;             // by camera
};

std::map<std::string, std::string> OptionsOf(const std::string& command) {
  std::istringstream words(command);
  std::map<std::string, std::string> options;
  for (std::string word, value; words >> word;)
    if (word.starts_with("--") && words >> value) options[word.substr(2)] = value;
  return options;
}

void Extract(const std::string& command, Database& database) {
  const auto options = OptionsOf(command);
  ASSERT_EQ(options.at("FeatureExtraction.num_threads"), "1") << "in order";
  std::set<std::string> names;  // in the order of their bytes
  if (const auto list = options.find("image_list_path"); list != options.end()) {
    std::ifstream file(list->second);
    for (std::string name; std::getline(file, name);) names.insert(name);
  } else {
    for (const auto& entry : fs::directory_iterator(options.at("image_path")))
      names.insert(entry.path().filename());
  }
  bool is_first = true;
  for (const std::string& name : names) {
    EXPECT_TRUE(fs::exists(fs::path(options.at("image_path")) / name)) << name;
    if (options.contains("ImageReader.mask_path")) {
      EXPECT_TRUE(fs::exists(options.at("ImageReader.mask_path") + "/" + name + ".png"));
    }
    if (is_first || options.contains("ImageReader.single_camera_per_image"))
      database.models[static_cast<long>(database.models.size()) + 1] = options.at("ImageReader.camera_model");
    is_first = false;
    database.images[name] = static_cast<long>(database.images.size()) + 1;
    database.camera_of[name] = static_cast<long>(database.models.size());
  }
}

struct RigsRead {
  std::map<long, long> camera_of_rig;
  struct Frame {
    long rig = 0, camera = 0, image = 0;
    std::vector<double> pose;
  };
  std::map<long, Frame> frames;
};

RigsRead ReadRigsText(const fs::path& model) {
  RigsRead read;
  const auto rows = [&](const char* name, const auto& use) {
    std::ifstream file(model / name);
    for (std::string line; std::getline(file, line);) {
      std::istringstream row(line);
      if (line[0] != '#') use(row);
    }
  };
  std::string word;
  rows("rigs.txt", [&](std::istringstream& row) {
    long rig = 0, sensors = 0;
    row >> rig >> sensors >> word >> read.camera_of_rig[rig];
    EXPECT_TRUE(row && sensors == 1 && word == "CAMERA");
  });
  rows("frames.txt", [&](std::istringstream& row) {
    long id = 0, images = 0;
    row >> id;
    RigsRead::Frame& frame = read.frames[id];
    row >> frame.rig;
    frame.pose.resize(7);
    for (double& number : frame.pose) row >> number;
    row >> images >> word >> frame.camera >> frame.image;
    EXPECT_TRUE(row && images == 1 && word == "CAMERA");
  });
  return read;
}

// As ReadRigsBinary() and ReadFramesBinary() of src/colmap/scene/reconstruction_io_binary.cc.
RigsRead ReadRigsBinary(const fs::path& model) {
  RigsRead read;
  std::ifstream rigs(model / "rigs.bin", std::ios::binary), frames(model / "frames.bin", std::ios::binary);
  const auto get = [](std::ifstream& file, auto value) {
    file.read(reinterpret_cast<char*>(&value), sizeof value);
    EXPECT_TRUE(file.good());
    return value;
  };
  for (auto left = get(rigs, std::uint64_t{}); left > 0; --left) {
    const auto id = get(rigs, std::uint32_t{});
    EXPECT_EQ(get(rigs, std::uint32_t{}), 1u);
    EXPECT_EQ(get(rigs, std::int32_t{}), 0);
    read.camera_of_rig[id] = get(rigs, std::uint32_t{});
  }
  for (auto left = get(frames, std::uint64_t{}); left > 0; --left) {
    RigsRead::Frame& frame = read.frames[get(frames, std::uint32_t{})];
    frame.rig = get(frames, std::uint32_t{});
    for (int i = 0; i < 7; ++i) frame.pose.push_back(get(frames, double{}));
    EXPECT_EQ(get(frames, std::uint32_t{}), 1u);
    EXPECT_EQ(get(frames, std::int32_t{}), 0);
    frame.camera = get(frames, std::uint32_t{});
    frame.image = static_cast<long>(get(frames, std::uint64_t{}));
  }
  EXPECT_EQ(rigs.peek(), EOF);
  EXPECT_EQ(frames.peek(), EOF);
  return read;
}

void ExpectColmapTakesIt(const fs::path& out, const Database& database, bool binary) {
  const ColmapRead model = test::ReadAsColmap(out / "sparse/0");
  const RigsRead rigs = binary ? ReadRigsBinary(out / "sparse/0") : ReadRigsText(out / "sparse/0");
  ASSERT_EQ(model.images.size(), database.images.size());
  ASSERT_EQ(rigs.frames.size(), database.images.size());
  ASSERT_EQ(model.cameras.size(), database.models.size());
  ASSERT_EQ(rigs.camera_of_rig.size(), database.models.size());
  for (const auto& [id, camera] : model.cameras) {
    EXPECT_EQ(camera.model, database.models.at(id));
    EXPECT_EQ(rigs.camera_of_rig.at(id), id);
  }
  for (const auto& [id, image] : model.images) {
    EXPECT_EQ(id, database.images.at(image.name));
    EXPECT_EQ(image.camera, database.camera_of.at(image.name));
    const RigsRead::Frame& frame = rigs.frames.at(id);
    EXPECT_EQ(frame.image, id);
    EXPECT_EQ(frame.camera, image.camera);
    EXPECT_EQ(frame.rig, image.camera);
    const Eigen::Quaterniond& q = image.rotation;
    const Eigen::Vector3d& t = image.translation;
    EXPECT_THAT(frame.pose, ElementsAre(q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()));
  }
}

CameraModel WiderThan(CameraModel camera, double factor) {
  camera.fx *= factor;
  return camera;
}

// Views that were taken back have left gaps in the numbers; names stand in another order than views.
TEST(ColmapFolder, NumbersAreThoseOfTheDatabase) {
  const ScratchFolder scratch;
  std::vector<CameraModel> eight;
  for (int i = 0; i < 8; ++i) eight.push_back(WiderThan(test::Straight(), 1 + 0.01 * i));
  const std::vector<std::pair<std::vector<CameraModel>, std::size_t>> sets{
      {{test::Straight()}, 1}, {{test::Lens(), test::Straight(), test::Fisheye()}, 3}, {eight, 1}};
  for (const auto& [cameras, runs] : sets) {
    const fs::path dir = scratch / fmt::format("lf{}", cameras.size());
    LightField source = TrackedLightField(dir, cameras, 8, cameras.size() == 1);
    fs::rename(dir / source.views[2].image_path, dir / "images/Z.png");
    source.views[2].image_path = "images/Z.png";
    fs::rename(dir / source.views[5].image_path, dir / "images/00.png");
    source.views[5].image_path = "images/00.png";
    for (const bool binary : {false, true}) {
      const fs::path out = scratch / fmt::format("out{}{}", cameras.size(), binary);
      const ExportForm form = binary ? ExportForm::kColmapBinary : ExportForm::kColmapText;
      const ExportSummary summary = ExportLightField(source, out, {.form = form});
      ASSERT_THAT(summary.commands, SizeIs(runs + 3));
      Database database;
      for (std::size_t i = 0; i < runs; ++i) Extract(summary.commands[i], database);
      ExpectColmapTakesIt(out, database, binary);
      const auto last = OptionsOf(summary.commands.back());
      EXPECT_EQ(last.at("input_path"), (out / "sparse/0").string());
      EXPECT_THAT(summary.commands[runs + 1], HasSubstr(last.at("output_path"))) << "makes the folder";
    }
  }
}

TEST(ColmapFolder, ASingleViewHasNothingToTriangulate) {
  const ScratchFolder scratch;
  const LightField source = TrackedLightField(scratch / "lf", {test::Straight()}, 1);
  EXPECT_THAT(ExportLightField(source, scratch / "out", {.form = ExportForm::kColmapText}).commands,
              IsEmpty());
  EXPECT_EQ(test::ReadAsColmap(scratch / "out/sparse/0").images.size(), 1u);
}

// COLMAP takes a fisheye whose coefficients are below 1e-8 for a pinhole.
TEST(ColmapFolder, AFisheyeWithoutDistortionStaysOne) {
  const ScratchFolder scratch;
  CameraModel straight = test::Fisheye();
  straight.coefficients = {};
  const LightField source = TrackedLightField(scratch / "lf", {straight, test::Fisheye()}, 4);
  const ExportSummary summary = ExportLightField(source, scratch / "out", {.form = ExportForm::kColmapText});
  EXPECT_THAT(summary.doubts, ElementsAre(testing::AllOf(HasSubstr("camera 1"), HasSubstr("undistort"))));
  const ColmapRead model = test::ReadAsColmap(scratch / "out/sparse/0");
  const auto& parameters = model.cameras.at(1).parameters;
  EXPECT_GT(parameters[4], 1e-8);
  CameraModel written = straight;
  std::copy(parameters.begin() + 4, parameters.end(), written.coefficients.begin());
  for (double angle = 0; angle < 1.6; angle += 0.1) {
    const Eigen::Vector3d ray(std::sin(angle), 0, std::cos(angle));
    EXPECT_LT((*written.ImgFromCam(ray) - *straight.ImgFromCam(ray)).norm(), 1e-3);
  }
  EXPECT_EQ(model.cameras.at(2).parameters[4], test::Fisheye().coefficients[0]);
  EXPECT_THAT(
      ExportLightField(source, scratch / "pinhole", {.form = ExportForm::kColmapText, .undistort = true})
          .doubts,
      IsEmpty());
}

// An environment variable for the length of a test.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* usual = std::getenv(name)) before_ = usual;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() {
    if (before_)
      setenv(name_, before_->c_str(), 1);
    else
      unsetenv(name_);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// A program in COLMAP's place, which prints this help and knows options of this kind.
void InstallColmap(const fs::path& folder, const std::string& help, const std::string& kind) {
  std::ofstream(folder / "colmap") << "#!/bin/sh\nif [ \"$1\" = help ]; then echo '" << help
                                   << "'; exit 0; fi\nfor name in num_threads use_gpu; do\n"
                                   << "  echo \"  --" << kind << "Extraction.$name arg (=1)\"\n"
                                   << "  echo \"  --" << kind << "Matching.$name arg (=1)\"\ndone\n";
  fs::permissions(folder / "colmap", fs::perms::owner_all);
}

TEST(InstalledColmap, IsAskedForItsOptions) {
  struct Case {
    std::string help, kind, display, number, extractor, matcher;
  };
  const std::string sift_gpu = " --SiftExtraction.use_gpu 0", gpu = " --FeatureExtraction.use_gpu 0";
  const Case cases[] = {
      {"COLMAP 3.8 -- Structure\n(Commit a without CUDA)", "Sift", "", "3.8", sift_gpu,
       " --SiftMatching.use_gpu 0"},
      {"COLMAP 3.8 -- Structure\n(Commit a without CUDA)", "Sift", ":0", "3.8", "", ""},
      {"COLMAP 3.12.1 -- Structure\n(Commit a without CUDA)\n  rig_configurator", "Sift", "", "3.12.1",
       " --SiftExtraction.num_threads 1" + sift_gpu, " --SiftMatching.use_gpu 0"},
      {"COLMAP 4.0 -- Structure\n(Commit a without CUDA)\n  rig_configurator", "Feature", "", "4.0",
       " --FeatureExtraction.num_threads 1" + gpu, " --FeatureMatching.use_gpu 0"},
      {"COLMAP 4.0 -- Structure\n(Commit a without CUDA)\n  rig_configurator", "Feature", ":0", "4.0",
       " --FeatureExtraction.num_threads 1", ""}};
  const Environment wayland("WAYLAND_DISPLAY", "");
  for (const Case& each : cases) {
    const ScratchFolder scratch;
    const Environment path("PATH", scratch.path().string()), display("DISPLAY", each.display);
    EXPECT_EQ(InstalledColmap().number, "") << "none in PATH";
    InstallColmap(scratch.path(), each.help, each.kind);
    const ColmapVersion colmap = InstalledColmap();
    EXPECT_EQ(colmap.number, each.number);
    EXPECT_EQ(colmap.extractor, each.extractor) << each.help << each.display;
    EXPECT_EQ(colmap.matcher, each.matcher) << each.help << each.display;
  }
}

TEST(InstalledColmap, IsThatOfTheCommands) {
  const ScratchFolder scratch;
  const ColmapVersion colmap{"3.8", " --SiftExtraction.use_gpu 0", " --SiftMatching.use_gpu 0"};
  for (const auto& lenses : {std::vector{test::Straight()}, std::vector{test::Lens(), test::Straight()}}) {
    const std::size_t cameras = lenses.size();
    const std::string name = std::to_string(cameras);
    const LightField source = TrackedLightField(scratch / ("lf" + name), lenses, 6);
    const auto commands =
        ExportLightField(source, scratch / name, {.form = ExportForm::kColmapText, .colmap = colmap})
            .commands;
    ASSERT_THAT(commands, SizeIs(cameras + 3));
    for (std::size_t i = 0; i < cameras; ++i)
      EXPECT_EQ(OptionsOf(commands[i]).at("SiftExtraction.use_gpu"), "0");
    EXPECT_EQ(OptionsOf(commands[cameras]).at("SiftMatching.use_gpu"), "0");
    EXPECT_THAT(testing::PrintToString(commands), testing::Not(HasSubstr("Feature")));
  }
}

}  // namespace
}  // namespace ulf::colmap_folder_test
