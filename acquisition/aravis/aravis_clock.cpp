#include "acquisition/aravis/aravis_clock.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <thread>

#include "acquisition/aravis/aravis_setting.h"
#include "core/base/host_time.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

struct ClockNames {
  const char* enable;
  const char* on;     // null: the feature is a Boolean
  const char* latch;  // what is read afterwards is of one moment; a camera may do without
  const char* status;
  const char* offset;
};
constexpr std::array kClockNames{
    ClockNames{"PtpEnable", nullptr, "PtpDataSetLatch", "PtpStatus", "PtpOffsetFromMaster"},
    ClockNames{"GevIEEE1588", nullptr, "GevIEEE1588DataSetLatch", "GevIEEE1588Status",
               "GevIEEE1588OffsetFromMaster"},
    ClockNames{"PtpMode", "Auto", nullptr, "PtpStatus",
               "PtpOffsetFromMaster"},  // Allied Vision, before PtpEnable
};
// Between two questions: while the lock is awaited, and while frames come. Guessed.
constexpr std::chrono::milliseconds kAskLock(50), kAskRunning(1000);

const ClockNames* NamesOf(const AravisSession& session) {
  for (const ClockNames& names : kClockNames)
    if (session.Has(names.enable)) return &names;
  return nullptr;
}

void Switch(const AravisSession& session, const std::string& who, const ClockNames& names, bool on) {
  const std::string word = names.on ? (on ? names.on : "Off") : (on ? "true" : "false");
  RequireSetting(session, who, on ? "ptp=on" : "ptp=off", names.enable, word);
}

bool IsOn(ArvCamera* camera, const ClockNames& names) {
  if (!names.on) return TryCall(arv_camera_get_boolean, camera, names.enable).value_or(false);
  return Text(TryCall(arv_camera_get_string, camera, names.enable).value_or("Off")) != "Off";
}

}  // namespace

AravisClock::AravisClock(const AravisSession& session, const std::string& who, const AravisOptions& options,
                         std::vector<std::string>& notes)
    : session_(session), asked_(std::chrono::steady_clock::now()) {
  const ClockNames* names = NamesOf(session_);
  if (!names && options.ptp.value_or(false))
    throw Refused(who, "the camera's clock cannot be set by IEEE 1588", "leave ptp out");
  if (names && options.ptp) Switch(session, who, *names, *options.ptp);
  state_ = Query();
  if (!options.ptp.value_or(false)) return;
  const auto begin = std::chrono::steady_clock::now();
  while (!IsShared() && SecondsSince(begin) < options.ptp_wait_s && !StopOnSignal::Requested()) {
    std::this_thread::sleep_for(kAskLock);
    state_ = Query();
  }
  if (!IsShared())
    throw Error(
        "{}: its clock follows no IEEE 1588 master within {:g} s (it says {}); run one on this network "
        "('ptp4l -i INTERFACE -m' of linuxptp on this computer), give ptp_wait_s, or leave ptp out",
        who, options.ptp_wait_s, state_ ? state_->status : "nothing");
  notes.push_back(fmt::format(
      "{} after {:.1f} s{}",
      state_->status == "Master" ? "is the IEEE 1588 master of its network" : "follows an IEEE 1588 clock",
      SecondsSince(begin), state_->offset_ns ? fmt::format(", {:.0f} ns from it", *state_->offset_ns) : ""));
}

void AravisClock::AppendTo(TransportFigures& transport) const {
  if (state_) transport.emplace_back(TransportFigure::kClockShared, state_->IsShared());
  if (state_ && state_->offset_ns)
    transport.emplace_back(TransportFigure::kClockOffsetNs, *state_->offset_ns);
}

std::optional<ClockState> AravisClock::Query() const {
  ArvCamera* camera = session_.Camera();
  const ClockNames* names = NamesOf(session_);
  if (!names || !IsOn(camera, *names)) return std::nullopt;
  if (names->latch && session_.Has(names->latch)) FailureOf(arv_camera_execute_command, camera, names->latch);
  ClockState state;
  state.status = Text(TryCall(arv_camera_get_string, camera, names->status).value_or(nullptr));
  if (session_.Has(names->offset)) {
    constexpr gint64 kUnknown = std::numeric_limits<gint64>::min();
    const gint64 offset = TryCall(arv_camera_get_integer, camera, names->offset).value_or(kUnknown);
    if (offset != kUnknown) state.offset_ns = static_cast<double>(offset);
  }
  return state;
}

std::optional<std::string> AravisClock::Poll() {
  if (!state_ || std::chrono::steady_clock::now() - asked_ < kAskRunning) return std::nullopt;
  const bool was_shared = IsShared();
  const std::optional<ClockState> now = Query();
  asked_ = std::chrono::steady_clock::now();
  if (!now || now->status.empty()) return std::nullopt;  // a camera that is gone is found out elsewhere
  state_ = now;
  if (was_shared == IsShared()) return std::nullopt;
  return was_shared ? fmt::format(
                          "the camera no longer follows its IEEE 1588 master (it says {}): its times drift "
                          "from now on",
                          state_->status)
                    : fmt::format("the camera follows an IEEE 1588 clock again ({})", state_->status);
}

}  // namespace ulf::acquisition
