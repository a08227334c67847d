// Tests: coverage/simulated_operator/simulated_operator, commands/capture/capture_command.
//
// A simulated person holds the simulated camera of `ulf capture`: the whole way from pictures to coverage.
// Every day with small pictures and poses as the simulator knows them; in the long tests at full size,
// tracked.
#include <gmock/gmock.h>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "acquisition/simulator/scene/scene.h"
#include "core/base/json_text.h"
#include "tests/support/floors.h"
#include "tests/support/test_paths.h"

namespace ulf::test::operator_capture_test {
namespace {

using ::testing::HasSubstr;

nlohmann::json Captured(const std::string& name, const std::string& arguments) {
  ScratchFolder scratch;
  const auto run = RunUlf("capture --no-geometry " + arguments + " -o " + (scratch / "lf").string() +
                          " --headless --json");
  EXPECT_EQ(run.exit_code, 0) << name << ": " << run.errors;
  EXPECT_THAT(run.errors, ::testing::Not(HasSubstr("no new coverage")))
      << name << ": all of it can be reached";
  return run.exit_code == 0 ? JsonFromText(run.output) : nlohmann::json::object();
}

#ifndef ULF_ALL_SEEDS

TEST(OperatorCapture, APersonCoversTheCap) {
  const Subject& subject = Scene::Named("studio")->subject();
  const Eigen::Vector3d& center = subject.center_in_world;
  const std::string asked = fmt::format(
      "'sim:studio?width=160&height=120' --poses known --subject {:.6f},{:.6f},{:.6f},0.15 "
      "--until-covered 40x24:95% --quality fast --max-seconds 90",
      center.x(), center.y(), center.z());
  for (const char* who : {"guided:101", "novice:102"}) {
    const nlohmann::json result = Captured(who, asked + " --operator " + who);
    EXPECT_EQ(result.value("stopped_because", ""), "covered") << who << ": " << result;
    EXPECT_GE(result.value("covered", 0.0), 0.95) << who;
  }
}

TEST(OperatorCapture, OnlyASimulatedSceneCanBeHeld) {
  ScratchFolder scratch;
  const std::string rest = " --headless -o " + (scratch / "lf").string() + " --operator ";
  for (const std::string& device : {"replay:" + scratch.path().string(), std::string("sim:board")}) {
    const auto refused = RunUlf("capture --no-geometry " + device + rest + "guided");
    EXPECT_EQ(refused.exit_code, 2) << device;
    EXPECT_THAT(refused.errors, HasSubstr("not a simulated scene")) << device;
  }
  const auto unknown = RunUlf("capture --no-geometry sim:studio" + rest + "expert");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, HasSubstr("unguided-novice"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "lf")) << "nothing was begun";
}

#else

struct Day {
  std::uint64_t seed;
  bool novice;
  const char* quality;
};

class TrackedCapture : public ::testing::TestWithParam<Day> {};

// Two scenes and two sizes of subject, in turn. A hundredth more is asked for than promised: the last
// adjustment of the poses may open some of the cap again.
TEST_P(TrackedCapture, CoversTheCap) {
  const Day day = GetParam();
  const std::string who = fmt::format("{}:{}", day.novice ? "novice" : "guided", day.seed);
  const bool studio = day.seed % 2 == 1;
  const nlohmann::json result = Captured(
      who,
      fmt::format("'sim:{}?seed={}' --operator {} --subject-size {} --quality {} --until-covered 60x40:96% "
                  "--max-seconds 420",
                  studio ? "studio" : "easel", day.seed, who, studio ? 0.28 : 0.2, day.quality));
  EXPECT_EQ(result.value("stopped_because", ""), "covered") << who;
  EXPECT_GE(result.value("covered", 0.0), 0.95) << who;
}

std::vector<Day> Days() {
  std::vector<Day> days;
  for (std::uint64_t seed = 101; seed <= 120; ++seed)
    for (const bool novice : {false, true}) days.push_back({seed, novice, "fast"});
  for (const bool novice : {false, true}) days.push_back({101, novice, "high"});
  return days;
}

INSTANTIATE_TEST_SUITE_P(TwentySeeds, TrackedCapture, ::testing::ValuesIn(Days()), [](const auto& day) {
  return fmt::format("{}_{}_{}", day.param.novice ? "novice" : "guided", day.param.seed, day.param.quality);
});

#endif

}  // namespace
}  // namespace ulf::test::operator_capture_test
