#include "acquisition/aravis/aravis_session.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "acquisition/aravis/aravis_usb.h"
#include "acquisition/gige_vision/gige_vision_probe.h"
#include "core/base/mutex.h"
#include "core/base/stop_signal.h"

namespace ulf::acquisition {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

// Longer than a killed program keeps control (the camera's heartbeat time-out, three seconds by default), and
// longer than this process needs to close a session.
constexpr milliseconds kControlEnds(3500);
// Waits longer than this are reported. Guessed.
constexpr milliseconds kSilentWait(400);
// One question about who controls the camera may take so long. Guessed.
constexpr milliseconds kControlTimeout(400);
// A warning about the same camera is logged at most once in this time: a search for a camera opens it again
// and again. Guessed.
constexpr std::chrono::minutes kWarnAgain(1);

std::string ControllerText(const std::string& address) {
  const std::string who = QueryGigeController(address);
  return "another program controls this camera" + (who.empty() ? "" : ", from " + who);
}

std::string ControllerHint(const std::string& address) {
  return ControllerText(address) + "; close it (its control ends some seconds later), then try again";
}

void WarnSometimes(const std::string& text) {
  static Mutex mutex;
  static std::map<std::string, Clock::time_point> said ULF_GUARDED_BY(mutex);
  const MutexLock lock(mutex);
  const auto [entry, is_new] = said.try_emplace(text, Clock::now());
  if (!is_new && Clock::now() - entry->second < kWarnAgain) return;
  entry->second = Clock::now();
  spdlog::warn("{}", text);
}

// The library would retry for seconds without a message, as for an address without a camera.
void WaitForControl(const std::string& who, const std::string& address, AravisSession::Wanted wanted) {
  const auto begin = Clock::now();
  bool said = false;
  for (;;) {
    const GigeControl control = QueryGigeControl(address, kControlTimeout);
    if (control == GigeControl::kNoAnswer) {
      const std::string elsewhere =
          WrongNetworkText({.address = address, .netmask = "0.0.0.0"}, NetworkInterfaces());
      throw Error(
          "{}: no GigE Vision camera answers at {}; check power, cable and firewall (UDP port 3956){}", who,
          address, elsewhere.empty() ? "" : ". Perhaps the " + elsewhere);
    }
    if (control == GigeControl::kFree) return;
    const auto waited = Clock::now() - begin;
    if (waited > kSilentWait && !std::exchange(said, true)) {
      if (wanted == AravisSession::Wanted::kReading) {
        WarnSometimes(
            fmt::format("{}: {}: its settings can be read, not written", who, ControllerText(address)));
        return;
      }
      WarnSometimes(fmt::format("{}: {}; waiting {:.1f} s for its control to end", who,
                                ControllerText(address),
                                1e-3 * static_cast<double>((kControlEnds - kSilentWait).count())));
    }
    if (waited > kControlEnds) throw Error("{}: {}", who, ControllerHint(address));
    // Some cameras take any request as a heartbeat of the controlling program, even after it ended. So the
    // camera is asked once more only, at the end.
    const auto pause = waited > kSilentWait ? kControlEnds : milliseconds(50);
    for (const auto until = Clock::now() + pause; Clock::now() < until && !StopOnSignal::Requested();)
      std::this_thread::sleep_for(milliseconds(20));
  }
}

}  // namespace

std::unique_ptr<AravisSession> AravisSession::Open(const std::string& who, const std::string& open_by,
                                                   Wanted wanted) {
  if (g_hostname_is_ip_address(open_by.c_str())) WaitForControl(who, open_by, wanted);
  try {
    return std::make_unique<AravisSession>(CallOrThrow(
        who, "cannot be opened (check power, cable and address; 'ulf devices' lists what answers)",
        arv_camera_new, open_by.c_str()));
  } catch (const Error& error) {
    const std::string hint = UsbOpenHint(error.what(), UsbCameraPlaces());
    if (hint.empty()) throw;
    throw Error("{}: {}", who, hint);
  }
}

AravisSession::AravisSession(ArvCamera* camera) : camera_(camera) {
  if (ARV_IS_GV_DEVICE(Device()) || ARV_IS_UV_DEVICE(Device()))
    handler_ = g_signal_connect(Device(), "control-lost", G_CALLBACK(&AravisSession::OnControlLost), this);
}

AravisSession::~AravisSession() {
  if (handler_) g_signal_handler_disconnect(Device(), handler_);
  while (inside_handler_.load() > 0) std::this_thread::sleep_for(milliseconds(1));
  std::this_thread::sleep_for(milliseconds(50));
  ReleaseStream();
  g_object_unref(camera_);
}

void AravisSession::OnControlLost(ArvDevice* /*device*/, gpointer self) {
  auto* session = static_cast<AravisSession*>(self);
  ++session->inside_handler_;
  session->control_lost_ = true;
  --session->inside_handler_;
}

ArvGcNode* AravisSession::Node(const std::string& feature) const {
  return feature.empty() ? nullptr : arv_device_get_feature(Device(), feature.c_str());
}

bool AravisSession::Has(const std::string& feature) const {
  return !feature.empty() &&
         TryCall(arv_camera_is_feature_available, camera_, feature.c_str()).value_or(false);
}

std::vector<std::string> AravisSession::Choices(const std::string& enumeration) const {
  return CallForNames(arv_camera_dup_available_enumerations_as_strings, camera_, enumeration.c_str());
}

bool AravisSession::IsController() const {
  return !ARV_IS_GV_DEVICE(Device()) || arv_gv_device_is_controller(ARV_GV_DEVICE(Device()));
}

std::string AravisSession::WhoControls() const { return ControllerHint(GigeAddress()); }

bool AravisSession::IsUsb() const { return ARV_IS_UV_DEVICE(Device()); }

bool AravisSession::UsbAnswers() const {
  guint32 version = 0;
  return TryCall(arv_device_read_register, Device(), 0, &version).value_or(false);
}

std::string AravisSession::GigeAddress() const {
  if (!ARV_IS_GV_DEVICE(Device())) return "";
  GSocketAddress* address = arv_gv_device_get_device_address(ARV_GV_DEVICE(Device()));
  char* text = g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address)));
  std::string result = Text(text);
  g_free(text);
  return result;
}

void AravisSession::Describe(DeviceInfo& info) const {
  info.maker = Text(TryCall(arv_camera_get_vendor_name, camera_).value_or(""));
  info.model = Text(TryCall(arv_camera_get_model_name, camera_).value_or(""));
  info.serial = Text(TryCall(arv_camera_get_device_serial_number, camera_).value_or(""));
  info.address = GigeAddress();
  info.bus = ARV_IS_GV_DEVICE(Device()) ? "GigEVision" : ARV_IS_UV_DEVICE(Device()) ? "USB3Vision" : "";
}

}  // namespace ulf::acquisition
