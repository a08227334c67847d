// Tests: render/photographs/photograph_store, render/photographs/photograph_loader,
// render/photographs/pyramid_file.
#include "render/photographs/photograph_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "core/base/error.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/gl/gl_renderer.h"
#include "render/photographs/photograph_loader.h"
#include "tests/render/scenes/synthetic_views.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::photograph_store_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

bool Equal(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

// A light field of 3 x 3 views, of 96 x 72 pixels: a pyramid has 7 levels and 27,588 bytes.
class PhotographStoreTest : public ::testing::Test {
 protected:
  PhotographStoreTest() {
    test::WriteLightField(dir_, {.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)}, true);
  }
  PhotographStore Open(const PhotographStoreOptions& options = {}) {
    return PhotographStore(ReadLightField(dir_), options);
  }
  fs::path PhotographFile(std::size_t index) { return dir_ / ReadLightField(dir_).views[index].image_path; }
  ViewPyramid Truth(std::size_t index) { return MakePyramid(cv::imread(PhotographFile(index).string())); }
  std::vector<fs::path> PyramidFiles() {
    std::vector<fs::path> files;
    if (fs::exists(dir_ / kPyramidFolder))
      for (const auto& entry : fs::directory_iterator(dir_ / kPyramidFolder)) files.push_back(entry.path());
    return files;
  }

  test::ScratchFolder scratch_;
  fs::path dir_ = scratch_ / "lf";
};

TEST_F(PhotographStoreTest, DecodesEachPhotographOnce) {
  const ViewPyramid truth = Truth(4);
  for (const bool again : {false, true}) {
    const PhotographStore store = Open();
    EXPECT_EQ(store.counts().decoded, 0u);
    const auto photograph = store.PhotographOf(4);
    ASSERT_EQ(photograph->LevelCount(), static_cast<int>(truth.size()));
    for (int level = photograph->LevelCount() - 1; level >= 0; --level) {
      EXPECT_EQ(photograph->LevelSize(level), truth[static_cast<std::size_t>(level)].size());
      EXPECT_TRUE(Equal(photograph->Level(level), truth[static_cast<std::size_t>(level)])) << level;
    }
    EXPECT_EQ(store.counts().decoded, again ? 0u : 1u);
    EXPECT_EQ(store.counts().files_written, again ? 0u : 1u);
    EXPECT_EQ(store.counts().levels_read, again ? truth.size() : 0u);
    EXPECT_EQ(PyramidFiles().size(), 1u);
  }
}

TEST_F(PhotographStoreTest, LinearLightHasFilesOfItsOwn) {
  const cv::Mat linear = Open({.linear = true}).PhotographOf(0)->Level(1),
                encoded = Open().PhotographOf(0)->Level(1);
  EXPECT_EQ(linear.type(), CV_16FC4);
  EXPECT_EQ(encoded.type(), CV_8UC3);
  EXPECT_EQ(PyramidFiles().size(), 2u);
  const PhotographStore store = Open({.linear = true});
  EXPECT_TRUE(Equal(store.PhotographOf(0)->Level(1), linear));
  EXPECT_EQ(store.counts().decoded, 0u);
}

TEST_F(PhotographStoreTest, DamagedFilesAreMadeAgain) {
  const cv::Mat truth = Open().PhotographOf(4)->Level(0);
  ASSERT_EQ(PyramidFiles().size(), 1u);
  const fs::path file = PyramidFiles().front();
  const auto size = static_cast<std::streamoff>(fs::file_size(file));
  // Magic, key, size, a checksum, and pixels of the finest level.
  for (const std::streamoff at : {std::streamoff{0}, std::streamoff{9}, std::streamoff{24},
                                  std::streamoff{60}, size - 5000, size - 1}) {
    {
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      stream.seekg(at);
      const char was = static_cast<char>(stream.get());
      stream.seekp(at);
      stream.put(static_cast<char>(was ^ 4));
    }
    const PhotographStore store = Open();
    EXPECT_TRUE(Equal(store.PhotographOf(4)->Level(0), truth)) << at;
    EXPECT_EQ(store.counts().files_refused, 1u) << at;
    EXPECT_EQ(store.counts().decoded, 1u) << at;
  }
  fs::resize_file(file, static_cast<std::uintmax_t>(size / 2));
  EXPECT_TRUE(Equal(Open().PhotographOf(4)->Level(0), truth));
  const PhotographStore healed = Open();
  EXPECT_TRUE(Equal(healed.PhotographOf(4)->Level(0), truth));
  EXPECT_EQ(healed.counts().decoded, 0u);
}

TEST_F(PhotographStoreTest, AChangedPhotographIsSeen) {
  const cv::Mat before = Open().PhotographOf(4)->Level(0);
  const cv::Mat other(72, 96, CV_8UC3, cv::Scalar(10, 200, 30));
  cv::imwrite(PhotographFile(4).string(), other);
  fs::last_write_time(PhotographFile(4),
                      fs::last_write_time(PhotographFile(4)) + std::chrono::milliseconds(5));
  EXPECT_TRUE(Equal(Open().PhotographOf(4)->Level(0), other));
  // Of the same size in bytes, too.
  const auto time = fs::last_write_time(PhotographFile(4));
  fs::last_write_time(PhotographFile(4), time + std::chrono::milliseconds(5));
  const PhotographStore store = Open();
  EXPECT_TRUE(Equal(store.PhotographOf(4)->Level(0), other));
  EXPECT_EQ(store.counts().files_refused, 1u);
}

TEST_F(PhotographStoreTest, MemoryHoldsWhatWasUsedLast) {
  const PhotographStore store = Open({.memory_limit_mb = 0.06});  // two pyramids
  for (int round = 0; round < 3; ++round)
    for (std::size_t i = 0; i < 9; ++i) EXPECT_TRUE(Equal(store.PhotographOf(i)->Level(0), Truth(i)[0])) << i;
  EXPECT_LE(store.counts().most_held_bytes, 60000u);
  EXPECT_GT(store.counts().most_held_bytes, 40000u);
  const std::size_t read = store.counts().levels_read;
  store.PhotographOf(8)->Level(0);
  EXPECT_EQ(store.counts().levels_read, read);  // is held
  store.PhotographOf(0)->Level(0);
  EXPECT_EQ(store.counts().levels_read, read + 1);
}

TEST_F(PhotographStoreTest, WorksWithoutACacheAndSaysSo) {
  std::ofstream(dir_ / "cache") << "no folder";
  const auto run =
      test::RunUlf("render " + dir_.string() + " --field linear -o " + (scratch_ / "x.png").string());
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto said = run.errors.find("without cache/pyramids/ this light field takes longer");
  ASSERT_NE(said, std::string::npos) << run.errors;
  EXPECT_EQ(run.errors.find("without cache/pyramids/", said + 1), std::string::npos) << run.errors;
}

TEST_F(PhotographStoreTest, DoesNotWriteToForeignSets) {
  EXPECT_EQ(Open({.size_limit_px = 48}).PhotographOf(0)->Level(0).size(), cv::Size(48, 36));
  EXPECT_TRUE(PyramidFiles().empty());
  fs::remove(dir_ / "journal.jsonl");  // transforms.json is left: a set as nerfstudio has it
  EXPECT_TRUE(Equal(Open().PhotographOf(4)->Level(0), Truth(4)[0]));
  EXPECT_TRUE(PyramidFiles().empty());
}

TEST_F(PhotographStoreTest, MissingPhotographIsALateError) {
  const PhotographStore store = Open();
  fs::resize_file(PhotographFile(3), 100);
  EXPECT_THROW(store.PhotographOf(3)->Level(0), Error);
  EXPECT_NO_THROW(store.PhotographOf(4)->Level(0));
}

TEST_F(PhotographStoreTest, ServesManyReadersAtOnce) {
  std::vector<ViewPyramid> truths;
  for (std::size_t i = 0; i < 9; ++i) truths.push_back(Truth(i));
  std::atomic<int> wrong = 0;
  // Two stores are two programs.
  const PhotographStore first = Open({.memory_limit_mb = 0.1}), second = Open({.memory_limit_mb = 0.1});
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int n = 0; n < 40; ++n) {
        const auto index = static_cast<std::size_t>((n * 5 + t) % 9);
        const int level = (n + t) % 3;
        if (!Equal((t % 2 ? first : second).PhotographOf(index)->Level(level),
                   truths[index][static_cast<std::size_t>(level)]))
          ++wrong;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(PyramidFiles().size(), 9u);  // no temporary files are left
  EXPECT_EQ(first.counts().files_refused + second.counts().files_refused, 0u);
}

TEST(PhotographStore, FirstPictureOf800ViewsDecodesFew) {
  test::ScratchFolder scratch;
  test::WriteLightField(scratch / "lf", {.viewpoints = test::GridViewpoints(3, 3, 0.2, 2.0)}, true);
  LightField light_field = ReadLightField(scratch / "lf");
  const View pattern = light_field.views[0];
  light_field.views.clear();
  for (const Eigen::Vector3d& viewpoint : test::CapViewpoints(800, 0.8, 2.0)) {
    View view = pattern;
    view.id = static_cast<int>(light_field.views.size()) + 1;
    view.image_path = fmt::format("images/many{}.png", view.id);
    view.cam_from_world = LookAt(viewpoint, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY());
    fs::create_hard_link(scratch / "lf" / pattern.image_path, scratch / "lf" / view.image_path);
    light_field.views.push_back(view);
  }
  WriteLightField(light_field);
  for (const bool again : {false, true}) {
    const auto scene = LoadScene(ReadLightField(scratch / "lf"), {});
    ASSERT_EQ(scene->views.size(), 800u);
    EXPECT_EQ(scene->store->counts().decoded, 0u);
    GlRenderer renderer(scene, {});
    const Rendering picture = renderer.Render(
        scene->views[0].camera, LookAt({0.1, 0.05, 1.9}, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()));
    EXPECT_EQ(picture.empty_px, 0);
    const PhotographStore::Counts counts = scene->store->counts();
    EXPECT_GT(counts.decoded + counts.levels_read, 0u);
    EXPECT_LT(counts.decoded + counts.levels_read, 80u);
    if (again) {
      EXPECT_EQ(counts.decoded, 0u);
    }
  }
}

// ---- Reading ahead ----

// Made when they are asked for, which takes as long as a gate is shut.
class SlowPhotograph : public Photograph {
 public:
  explicit SlowPhotograph(int value) : Photograph({8, 8}, false), value_(value) {}
  cv::Mat Level(int level) const override {
    while (shut) std::this_thread::yield();
    ++asked;
    if (value_ < 0) throw Error("photograph {} is broken", value_);
    return cv::Mat(LevelSize(level), CV_8UC3, cv::Scalar::all(value_));
  }
  mutable std::atomic<int> asked = 0;
  std::atomic<bool> shut = false;

 private:
  int value_;
};

PhotographLoader::Request RequestOf(int number, const std::shared_ptr<SlowPhotograph>& photograph) {
  return {{number, 0}, photograph};
}

TEST(PhotographLoader, GivesPhotographsAndThrowsErrors) {
  PhotographLoader loader(2);
  EXPECT_FALSE(loader.Take({7, 0}));
  std::vector<PhotographLoader::Request> requests;
  for (int i = 0; i < 20; ++i) requests.push_back(RequestOf(i, std::make_shared<SlowPhotograph>(i)));
  requests.push_back(RequestOf(20, std::make_shared<SlowPhotograph>(-1)));
  loader.SetRequests(requests);
  for (int i = 19; i >= 0; --i) EXPECT_EQ(loader.Wait({i, 0}).at<cv::Vec3b>(3, 3)[1], i);
  EXPECT_THROW(loader.Wait({20, 0}), Error);
  EXPECT_FALSE(loader.Take({19, 0}));  // given away
}

TEST(PhotographLoader, DropsUnwantedRequests) {
  PhotographLoader loader(1);
  std::vector<std::shared_ptr<SlowPhotograph>> photographs;
  std::vector<PhotographLoader::Request> requests;
  for (int i = 0; i < 10; ++i) {
    photographs.push_back(std::make_shared<SlowPhotograph>(i));
    requests.push_back(RequestOf(i, photographs.back()));
  }
  photographs[0]->shut = true;
  loader.SetRequests(requests);
  loader.SetRequests({requests[9], requests[8]});
  photographs[0]->shut = false;
  EXPECT_EQ(loader.Wait({8, 0}).at<cv::Vec3b>(0, 0)[0], 8);
  EXPECT_EQ(photographs[9]->asked, 1);
  for (int i = 1; i < 8; ++i) EXPECT_EQ(photographs[static_cast<std::size_t>(i)]->asked, 0) << i;
  EXPECT_FALSE(loader.Take({0, 0}));
}

}  // namespace
}  // namespace ulf::photograph_store_test
