// Tests: acquisition/aravis/aravis_session, acquisition/aravis/aravis_stream.
//
// Letting go of a camera that dies, at moments all around the library's own "control lost" signal, which
// comes about five seconds after: a last reference that falls inside its emission would abort the process.
#include <gmock/gmock.h>

#include <random>
#include <thread>

#include "acquisition/device/device.h"
#include "tests/acquisition/aravis/aravis_fixture.h"

namespace ulf::test::aravis_teardown_test {
namespace {

class AravisTeardown : public CameraInNamespace {};

TEST_F(AravisTeardown, AtAnyMomentIsSafeAndQuick) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> around_signal_ms(4800, 5300);
  std::vector<int> moments_ms = {0, 300};
  for (int i = 0; i < 12; ++i) moments_ms.push_back(around_signal_ms(random));
  for (const int moment_ms : moments_ms) {
    StartCamera();
    auto device = OpenDriver("aravis:127.0.0.1?roi=320x240+0+0&fps=50");
    device->Start();
    Take(*device, 2);
    camera_->Kill();
    std::this_thread::sleep_for(std::chrono::milliseconds(moment_ms));
    const auto start = Clock::now();
    device.reset();
    EXPECT_LT(SecondsSince(start), 2) << moment_ms << " ms after the camera's end";
  }
}

}  // namespace
}  // namespace ulf::test::aravis_teardown_test
