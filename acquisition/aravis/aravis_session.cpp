#include "acquisition/aravis/aravis_session.h"

#include <chrono>
#include <thread>

#include "acquisition/aravis/gige_vision_probe.h"

namespace ulf {
namespace {

using std::chrono::milliseconds;

}  // namespace

std::unique_ptr<AravisSession> AravisSession::Open(const std::string& who, const std::string& open_by) {
  // The library waits out retries of seconds, both for an address where nobody answers and for a camera that
  // somebody controls. The latter may be a session of our own that is just being closed.
  if (g_hostname_is_ip_address(open_by.c_str())) {
    GigeControl control = GigeControl::kNoAnswer;
    for (int attempt = 0; attempt < 10; ++attempt) {
      control = AskGigeControl(open_by, milliseconds(400));
      if (control != GigeControl::kControlled) break;
      std::this_thread::sleep_for(milliseconds(50));
    }
    if (control == GigeControl::kNoAnswer) {
      const std::string elsewhere =
          WrongNetworkText({.address = open_by, .netmask = "0.0.0.0"}, NetworkInterfaces());
      throw Error(
          "{}: nothing answers as a GigE Vision camera at {}; check power, cable and firewall (UDP port "
          "3956){}",
          who, open_by, elsewhere.empty() ? "" : ". Perhaps the " + elsewhere);
    }
  }
  return std::make_unique<AravisSession>(
      Must(who, "cannot be opened (check power, cable and address; 'ulf devices' lists what answers)",
           [&](GError** e) { return arv_camera_new(open_by.c_str(), e); }));
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

bool AravisSession::IsController() const {
  return !ARV_IS_GV_DEVICE(Device()) || arv_gv_device_is_controller(ARV_GV_DEVICE(Device()));
}

std::string AravisSession::WhoControls() const {
  const std::string who = AskGigeController(GigeAddress());
  return fmt::format(
      "another program controls this camera{}; close it (its control ends some seconds later), then try "
      "again",
      who.empty() ? "" : ", from " + who);
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
  info.maker = Text(Maybe([&](GError** e) { return arv_camera_get_vendor_name(camera_, e); }, ""));
  info.model = Text(Maybe([&](GError** e) { return arv_camera_get_model_name(camera_, e); }, ""));
  info.serial = Text(Maybe([&](GError** e) { return arv_camera_get_device_serial_number(camera_, e); }, ""));
  info.bus = ARV_IS_GV_DEVICE(Device()) ? "GigEVision" : ARV_IS_UV_DEVICE(Device()) ? "USB3Vision" : "";
}

}  // namespace ulf
