#include "acquisition/aravis/aravis_watch.h"

#include <fmt/format.h>

#include <algorithm>

#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/counted.h"
#include "core/base/host_time.h"

namespace ulf::acquisition {
namespace {

// Seconds, and multiples of the frame period where that is longer. Without a frame that is due for so long
// the device stalls, and the camera is asked who controls it. Guessed.
constexpr double kStallS = 0.5;
// A camera that answers and sends nothing for so long is lost, to be opened anew. Guessed.
constexpr double kSilentS = 3, kSilentPeriods = 10;
// A camera that does not answer for so long is lost: the library's heartbeat reports a broken control channel
// within 5 s.
constexpr double kGoneS = 5.5;
// Pause between two questions while frames are missing, and while a hardware trigger is awaited. Guessed.
constexpr double kAskAgainS = 0.25, kAskIdleS = 1;
// How long the camera's answer about its control is awaited. Guessed.
constexpr std::chrono::milliseconds kAskWhileCapturing(200);

}  // namespace

AravisWatch::AravisWatch(const AravisSession& session, double period_s)
    : session_(session), period_s_(period_s), gige_address_(session.GigeAddress()) {}

double AravisWatch::PeriodSeconds() const {
  return std::max(period_s_, *std::min_element(gaps_s_.begin(), gaps_s_.end()));
}

double AravisWatch::StallSeconds() const { return std::max(kStallS, kStallPeriods * PeriodSeconds()); }

void AravisWatch::FrameCame(double gap_s) {
  std::rotate(gaps_s_.begin(), gaps_s_.begin() + 1, gaps_s_.end());
  gaps_s_.back() = gap_s;
}

std::optional<std::string> AravisWatch::LossReason(double silence_s, bool waits_for_trigger,
                                                   std::uint64_t refused_packets) {
  if (session_.ControlLost() && session_.IsUsb())
    return "the camera is no longer on the bus: its cable was pulled, or it lost its power";
  if (session_.ControlLost())
    return "the camera no longer answers, or another program took control of it; check power and cable";
  if (silence_s < StallSeconds() && !waits_for_trigger) return std::nullopt;
  const double silent_s = std::max(kSilentS, kSilentPeriods * PeriodSeconds());
  if (gige_address_.empty()) {
    if (waits_for_trigger || silence_s < silent_s) return std::nullopt;
    // Opening it anew clears an endpoint that is halted, which the library does not do while it streams.
    return session_.UsbAnswers()
               ? fmt::format(
                     "no frame for {:.1f} s although the camera answers: its stream has stopped; check "
                     "whether it waits for a trigger, and use a shorter cable or another port if this comes "
                     "again",
                     silence_s)
               : fmt::format("no frame for {:.1f} s, and the camera does not answer; check power and cable",
                             silence_s);
  }
  if (SecondsSince(asked_control_at_) > (waits_for_trigger ? kAskIdleS : kAskAgainS)) {
    const GigeControl control = QueryGigeControl(gige_address_, kAskWhileCapturing);
    asked_control_at_ = Clock::now();
    control_answered_ = control != GigeControl::kNoAnswer;
    if (control == GigeControl::kFree)
      return "the camera was restarted, or lost its network: it no longer knows this program";
  }
  if (waits_for_trigger) return std::nullopt;
  if (!control_answered_ && silence_s > std::max(kGoneS, silent_s))
    return fmt::format("the camera has not answered for {:.1f} s; check power and cable", silence_s);
  if (control_answered_ && silence_s > silent_s)
    return fmt::format(
        "no frame for {:.1f} s although the camera answers; check the firewall, the packet size "
        "(?packet_size=1400), and whether the camera waits for a trigger{}",
        silence_s,
        refused_packets == 0 ? ""
                             : fmt::format("; ulf refused {} of a kind that the camera was not set to send",
                                           Counted(refused_packets, "packet")));
  return std::nullopt;
}

}  // namespace ulf::acquisition
