// Tests: render/proxy/depth_map_files, render/proxy/proxy_choice.
#include "render/proxy/depth_map_files.h"
#include "core/base/json_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/light_field/folder/leftovers.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/proxy/geometry_state.h"
#include "render/proxy/mesh_file.h"
#include "render/proxy/proxy_choice.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/slow_disk.h"
#include "tests/support/test_paths.h"
#include "tests/support/test_run.h"

namespace ulf::test::depth_map_files_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class DepthMapFiles : public testing::Test {
 protected:
  explicit DepthMapFiles(std::uint64_t disk_bytes = 0) {
    if (disk_bytes > 0) why_no_disk_ = MountSmallDisk(scratch_.path(), disk_bytes);
    SceneSpec spec{.viewpoints = CapViewpoints(6, 0.4, 2.0)};
    WriteLightField(dir_, spec, true);
    light_field_ = ReadLightField(dir_);
    WriteMeshPly(dir_ / kMeshProxyFile, *mesh_);
    for (const View& view : light_field_.views)
      maps_.emplace(view.id, DepthMapOfMesh(*mesh_, light_field_.CameraOf(view).WithoutDistortion(),
                                            view.cam_from_world, 0.01));
  }
  KeptGeometry Write(const std::map<int, ViewDepthMap>& maps,
                     FormerGeometry former = FormerGeometry::kReplaced) const {
    return WriteGeometryFiles(light_field_, MeshPlyBytes(*mesh_), maps, former);
  }
  DepthMapReading Read() const { return ReadDepthMaps(dir_, light_field_, mesh_); }
  cv::Mat FirstMap() const {
    const DepthMapReading reading = Read();
    return reading.maps.at(1)->Get().inverse_depth.clone();
  }
  std::size_t FilesInFolder() const { return FilesIn(dir_ / kDepthMapsFolder); }
  static std::size_t FilesIn(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  std::map<int, ViewDepthMap> HalvedMaps() const {
    std::map<int, ViewDepthMap> others = maps_;
    for (auto& [id, map] : others) {
      const cv::Mat halved = map.inverse_depth / 2;
      map.inverse_depth = halved;
    }
    return others;
  }
  fs::path SomePng() const {
    for (const auto& entry : fs::directory_iterator(dir_ / kDepthMapsFolder))
      if (entry.path().extension() == ".png") return entry.path();
    return {};
  }

  ScratchFolder scratch_;
  std::optional<std::string> why_no_disk_;  // of a few bytes, where it was asked for
  fs::path dir_ = scratch_ / "field";
  LightField light_field_;
  std::shared_ptr<const TriangleMesh> mesh_ = PlaneAndSquare();
  std::map<int, ViewDepthMap> maps_;
};

TEST_F(DepthMapFiles, ComeBackAsTheyWere) {
  EXPECT_FALSE(HasDepthMaps(dir_));
  Write(maps_);
  ASSERT_TRUE(HasDepthMaps(dir_));
  const DepthMapReading reading = Read();
  EXPECT_EQ(reading.stale, 0u);
  ASSERT_EQ(reading.maps.size(), maps_.size());
  for (const auto& [id, map] : maps_) {
    const ViewDepthMap& read = reading.maps.at(id)->Get();
    EXPECT_EQ(cv::norm(read.inverse_depth, map.inverse_depth, cv::NORM_INF), 0) << id;
    EXPECT_EQ(read.camera, map.camera);
    EXPECT_EQ(read.unit, map.unit);
    EXPECT_EQ(read.step, map.step);
  }
}

TEST_F(DepthMapFiles, AreNotUsedForAViewThatMoved) {
  Write(maps_);
  light_field_.views[2].cam_from_world.translation.x() += 1e-3;
  light_field_.views.pop_back();
  const DepthMapReading reading = Read();
  EXPECT_EQ(reading.stale, 2u);
  EXPECT_EQ(reading.maps.size(), 4u);
  EXPECT_FALSE(reading.maps.contains(light_field_.views[2].id));
}

TEST_F(DepthMapFiles, OfMovedOrRemovedViewsAreTakenOut) {
  std::map<int, Rigid3> made_under;
  for (const View& view : light_field_.views) made_under[view.id] = view.cam_from_world;
  const int rounded = light_field_.views[0].id, shifted = light_field_.views[1].id,
            turned = light_field_.views[2].id, gone = light_field_.views[3].id,
            nowhere = light_field_.views[4].id;
  made_under[rounded].translation.x() += 1e-9;
  const double distance =
      (light_field_.views[1].cam_from_world * light_field_.subject->center_in_world).norm();
  const double pixel = 1 / maps_.at(shifted).camera.MeanFocalPx();
  made_under[shifted].translation.x() += 0.3 * pixel * distance;
  made_under[turned].rotation =
      Eigen::AngleAxisd(0.3 * pixel, Eigen::Vector3d::UnitY()) * made_under[turned].rotation;
  made_under.erase(nowhere);
  std::erase_if(light_field_.views, [&](const View& view) { return view.id == gone; });
  std::map<int, ViewDepthMap> maps = maps_;
  EXPECT_EQ(TakeOutMovedMaps(light_field_, made_under, maps), 3u);
  EXPECT_EQ(maps.size(), maps_.size() - 4);
  EXPECT_TRUE(maps.contains(rounded));
  for (const int id : {shifted, turned, gone, nowhere}) EXPECT_FALSE(maps.contains(id)) << id;
}

TEST_F(DepthMapFiles, AreKeptWithTheirMesh) {
  const fs::path depth = dir_ / kDepthMapsFolder;
  Write(maps_);
  const std::size_t files = FilesInFolder();
  WriteFileAtomically(depth / "000001.png", "a depth camera's");
  const std::string mesh = ReadWholeFile(dir_ / kMeshProxyFile);
  for (const char* number : {"", "-2"}) {
    const KeptGeometry kept = Write(HalvedMaps(), FormerGeometry::kKept);
    EXPECT_EQ(kept.mesh, dir_ / fmt::format("kept/proxy{}.ply", number));
    EXPECT_EQ(kept.maps, dir_ / fmt::format("kept/depth{}", number));
    EXPECT_EQ(ReadWholeFile(*kept.mesh), mesh);
    EXPECT_EQ(FilesIn(*kept.maps), files);
  }
  EXPECT_EQ(ReadWholeFile(depth / "000001.png"), "a depth camera's");
  // What was kept can be put back.
  fs::remove_all(depth);
  fs::rename(dir_ / "kept/depth", depth);
  fs::rename(dir_ / "kept/proxy.ply", dir_ / kMeshProxyFile);
  EXPECT_EQ(cv::norm(FirstMap(), maps_.at(1).inverse_depth, cv::NORM_INF), 0);
}

TEST_F(DepthMapFiles, AMeshWithoutMapsTakesThemAway) {
  Write(maps_);
  Write({});
  EXPECT_FALSE(HasDepthMaps(dir_));
  EXPECT_FALSE(fs::exists(dir_ / kDepthMapsFolder));
  EXPECT_EQ(GeometryStateOf(light_field_)->problem, "");
}

// SIGKILL before each call that changes the disk: the geometry is the one of before or the new one, with all
// of its maps, and the next writer leaves nothing else.
TEST_F(DepthMapFiles, AKillLeavesOneGeometryOrTheOther) {
  const TriangleMesh other{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const std::string ply = MeshPlyBytes(other);
  Write(maps_);
  const fs::path start = scratch_ / "start";
  fs::rename(dir_, start);
  for (const FormerGeometry former : {FormerGeometry::kReplaced, FormerGeometry::kKept}) {
    int old_ones = 0, new_ones = 0, killed = 0;
    for (int call = 1;; ++call) {
      fs::remove_all(dir_);
      fs::copy(start, dir_, fs::copy_options::recursive);
      const pid_t child = fork();
      if (child == 0) {
        DieBeforeDiskCall(call);
        WriteGeometryFiles(light_field_, ply, HalvedMaps(), former);
        _exit(0);
      }
      int status = 0;
      waitpid(child, &status, 0);
      const bool is_new = ReadWholeFile(dir_ / kMeshProxyFile) == ply;
      const DepthMapReading reading = Read();
      EXPECT_EQ(reading.maps.size(), maps_.size()) << "call " << call;
      const cv::Mat first = reading.maps.at(1)->Get().inverse_depth;
      EXPECT_EQ(cv::norm(first, (is_new ? HalvedMaps() : maps_).at(1).inverse_depth, cv::NORM_INF), 0)
          << "call " << call;
      EXPECT_EQ(GeometryStateOf(light_field_)->problem, "") << "call " << call;
      (is_new ? new_ones : old_ones) += 1;
      if (WIFEXITED(status)) break;
      ++killed;
      RemoveLeftovers(dir_, false);
      FinishGeometryFiles(dir_);
      EXPECT_EQ(FilesInFolder(), maps_.size() + 1) << "call " << call;
      const bool keeps = former == FormerGeometry::kKept && is_new;
      EXPECT_EQ(fs::exists(dir_ / "kept/proxy.ply"), keeps) << "call " << call;
      EXPECT_EQ(fs::exists(dir_ / "kept/depth/maps.json"), keeps) << "call " << call;
      if (keeps) {
        EXPECT_EQ(FilesIn(dir_ / "kept/depth"), maps_.size() + 1) << "call " << call;
      }
    }
    EXPECT_GT(old_ones, 3);
    EXPECT_GT(new_ones, 3);
    PrintFaultRow(fmt::format("SIGKILL before each call that changes the disk: mesh and depth maps {}",
                              former == FormerGeometry::kKept ? "that keep the former ones" : "replaced"),
                  killed, "0 times a mesh without its maps", std::nullopt);
  }
}

class DepthMapFilesOnASmallDisk : public DepthMapFiles {
 protected:
  DepthMapFilesOnASmallDisk() : DepthMapFiles(8 << 20) {}
};

TEST_F(DepthMapFilesOnASmallDisk, KeepTheOldOnesWhenFull) {
  if (why_no_disk_) GTEST_SKIP() << *why_no_disk_;
  std::map<int, ViewDepthMap> others = maps_;
  cv::RNG random(1);
  std::uint64_t bytes = 0;
  for (auto& [id, map] : others) {
    map.inverse_depth = map.inverse_depth.clone();
    random.fill(map.inverse_depth, cv::RNG::UNIFORM, 1, 65535);  // hardly gets smaller as a PNG
    bytes += 2 * map.inverse_depth.total();
  }
  const auto fill = [&] {
    std::ofstream(scratch_ / "room") << std::string(bytes / 2, 'x');
    FillDisk(scratch_ / "filled");
    fs::remove(scratch_ / "room");
  };
  fill();
  EXPECT_THROW(Write(others), DiskFullError);
  EXPECT_FALSE(fs::exists(dir_ / kDepthMapsFolder));
  fs::remove(scratch_ / "filled");

  Write(maps_);
  fill();
  EXPECT_THROW(Write(others), DiskFullError);
  EXPECT_EQ(FilesInFolder(), maps_.size() + 1);
  EXPECT_EQ(cv::norm(FirstMap(), maps_.at(1).inverse_depth, cv::NORM_INF), 0);
  fs::remove(scratch_ / "filled");
  Write(others);
  EXPECT_EQ(FilesInFolder(), others.size() + 1);
  EXPECT_EQ(cv::norm(FirstMap(), others.at(1).inverse_depth, cv::NORM_INF), 0);
}

TEST_F(DepthMapFiles, FilesOfOtherProgramsStay) {
  fs::create_directories(dir_ / kDepthMapsFolder / "raw");
  WriteFileAtomically(dir_ / kDepthMapsFolder / "000001.png", "a depth camera's");
  Write(maps_);
  Write(maps_);
  EXPECT_EQ(ReadWholeFile(dir_ / kDepthMapsFolder / "000001.png"), "a depth camera's");
  EXPECT_TRUE(fs::exists(dir_ / kDepthMapsFolder / "raw"));
}

TEST_F(DepthMapFiles, TheMeshStandsInForAMapThatIsDamaged) {
  Write(maps_);
  const std::string whole = ReadWholeFile(SomePng());
  WriteFileAtomically(SomePng(), whole.substr(0, whole.size() / 2));
  testing::internal::CaptureStdout();
  const DepthMapReading reading = Read();
  for (const auto& [id, map] : reading.maps) {
    const ViewDepthMap& read = map->Get();
    EXPECT_LE(cv::norm(read.inverse_depth, maps_.at(id).inverse_depth, cv::NORM_INF), 1) << id;
  }
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("the mesh stands in"));
}

TEST_F(DepthMapFiles, InvalidIndexFallsBackToTheMesh) {
  Write(maps_);
  EXPECT_THAT(OwnProxies(dir_), testing::Contains("soft"));
  const fs::path index = dir_ / kDepthMapsFolder / "maps.json";
  const std::string whole = ReadWholeFile(index);
  const auto refusal = [&](const std::string& text) {
    WriteFileAtomically(index, text);
    try {
      Read();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal(whole.substr(0, whole.size() / 2)), HasSubstr("cut short"));
  EXPECT_THAT(refusal("{}"), HasSubstr("no index of depth maps"));
  EXPECT_THAT(refusal("{\"format\": 5, \"maps\": []}"), HasSubstr("no index of depth maps"));
  nlohmann::json changed = JsonFromText(whole);
  changed["maps"][0]["file"] = "../../secret.png";
  EXPECT_THAT(refusal(JsonText(changed)), HasSubstr("lies elsewhere"));
  changed = JsonFromText(whole);
  changed["maps"][0]["step"] = 0;
  EXPECT_THAT(refusal(JsonText(changed)), HasSubstr("must be positive"));
  changed = JsonFromText(whole);
  changed["maps"][0]["camera"]["width"] = 1900000000;
  EXPECT_THAT(refusal(JsonText(changed)), HasSubstr("larger than the photograph"));
  WriteMeshPly(dir_ / kMeshProxyFile, TriangleMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  EXPECT_THAT(refusal(whole), HasSubstr("another mesh"));
  const auto proxies = EveryProxyOf(dir_, *light_field_.subject);
  EXPECT_EQ(proxies.back()->Name(), "mesh");
  EXPECT_THROW(ProxyFromName("soft", *light_field_.subject, dir_), Error);
}

}  // namespace
}  // namespace ulf::test::depth_map_files_test
