// Tests: core/light_field/folder/journal, core/light_field/exchange/read_posed_set,
// core/image/files/exr_file, core/light_field/points/point_io, tracking/sources/pose_stream,
// render/stereo/swept_maps, acquisition/gige_vision/gige_vision_probe,
// acquisition/simulator/gige/gvcp_server.
//
// Every file of the corpus, which the fuzzer has found or a person has written, through its door again.
#include <gmock/gmock.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <filesystem>
#include <set>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "tests/fuzz/fuzz_targets.h"

namespace ulf::test {
namespace {

namespace fs = std::filesystem;

struct Read {
  int files = 0, accepted = 0;
  std::string refusals;
};

double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e-3 * static_cast<double>(usage.ru_maxrss);
}

Read CorpusThrough(const FuzzTarget& target) {
  Read read;
  for (const auto& entry : fs::directory_iterator(fs::path(FUZZ_CORPUS) / target.name)) {
    const std::string bytes = ReadWholeFile(entry.path());
    ++read.files;
    const double before = PeakMegabytes();
    try {
      target.read(bytes);
      ++read.accepted;
    } catch (const Error& error) {
      read.refusals += fmt::format("{}: {}\n", entry.path().filename().string(), error.what());
    } catch (const std::exception& other) {
      ADD_FAILURE() << entry.path() << ": not an Error: " << other.what();
    }
    EXPECT_LT(PeakMegabytes() - before, 600)
        << entry.path() << " of " << bytes.size() << " bytes takes megabytes";
  }
  return read;
}

class FuzzCorpus : public ::testing::TestWithParam<FuzzTarget> {};

// A door that takes nothing of its corpus is a door that the fuzzer never got through.
TEST_P(FuzzCorpus, IsReadOrRefusedWithAnError) {
  spdlog::set_level(spdlog::level::off);
  const Read read = CorpusThrough(GetParam());
  EXPECT_GE(read.files, 3);
  EXPECT_GE(read.accepted, 1) << read.refusals;
}

INSTANTIATE_TEST_SUITE_P(Doors, FuzzCorpus, ::testing::ValuesIn(FuzzTargets().begin(), FuzzTargets().end()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(FuzzCorpusFolder, HasNoOtherTargets) {
  std::set<std::string> folders, targets;
  for (const auto& entry : fs::directory_iterator(FUZZ_CORPUS)) folders.insert(entry.path().filename());
  for (const FuzzTarget& target : FuzzTargets()) targets.insert(target.name);
  EXPECT_EQ(folders, targets);
}

}  // namespace
}  // namespace ulf::test
