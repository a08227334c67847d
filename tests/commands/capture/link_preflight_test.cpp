// Tests: commands/capture/capture_command, coverage/session/preflight, coverage/session/capture_meters,
// acquisition/link/link_facts.
//
// What is known of the link to a camera is said before a capture's first view, with the remedy.
#include <gmock/gmock.h>

#include "acquisition/calibration/calibration_io.h"
#include "acquisition/simulator/gige/simulated_gige_camera.h"
#include "tests/support/child_process.h"
#include "tests/support/floors.h"
#include "tests/support/own_namespaces.h"
#include "tests/support/test_paths.h"

namespace ulf::test::link_preflight_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LinkPreflight, NamesAThrottledCamera) {
  static const std::optional<std::string> why_not = EnterLoopbackNamespace();
  if (why_not) GTEST_SKIP() << *why_not;
  const ScratchFolder scratch;
  GigeServerOptions options;
  options.simulation.width = 320;
  options.simulation.height = 240;
  const SimulatedGigeCamera camera(options);
  WriteCalibration(scratch / "camera.json", camera.camera().camera(), options.serial, "exact");
  const auto said = [&](const std::string& settings) {
    ChildProcess capture({"/bin/sh", "-c",
                          "exec \"$ULF_BINARY\" capture 'aravis:127.0.0.1?format=Mono8&fps=30&" + settings +
                              "' -o " + (scratch / settings).string() + " --headless --calibration " +
                              (scratch / "camera.json").string() + " 2>&1"});
    return capture.ReadUntil("views at", 20);
  };
  const std::string limited = said("throughput_limit=1000000");
  EXPECT_THAT(limited,
              AllOf(HasSubstr("before the first view: camera's limit"),
                    HasSubstr("13.0 frames a second of the 30.0"), HasSubstr("throughput_limit=25344")));
  EXPECT_THAT(said("throughput_limit=50000000"), Not(HasSubstr("camera's limit")));
}

}  // namespace
}  // namespace ulf::test::link_preflight_test
