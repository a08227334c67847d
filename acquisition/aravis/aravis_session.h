// Owns an open camera of the library and its stream, and releases both safely.
//
// The library emits "control-lost" from its heartbeat thread while another thread may release the camera: if
// the last reference is dropped during the emission, the library waits for its own thread and aborts. So the
// handler only sets a flag; the destructor disconnects it, waits until it has returned, and gives the
// emission time to end. Releasing a camera that is gone blocks for seconds: callers use background_closer.h.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/aravis/aravis_calls.h"
#include "acquisition/device/device.h"

namespace ulf::acquisition {

class AravisSession {
 public:
  // kReading: a camera that another program controls is opened to be read.
  enum class Wanted { kControl, kReading };
  // `open_by`: from ResolveAravis(); `who` names the camera in errors. For kControl of a camera that another
  // program controls, logs that and waits: a killed program keeps control for some seconds. Throws Error.
  static std::unique_ptr<AravisSession> Open(const std::string& who, const std::string& open_by,
                                             Wanted wanted);
  explicit AravisSession(ArvCamera* camera);  // takes over the reference
  AravisSession(const AravisSession&) = delete;
  AravisSession& operator=(const AravisSession&) = delete;
  ~AravisSession();

  ArvCamera* Camera() const { return camera_; }
  ArvDevice* Device() const { return arv_camera_get_device(camera_); }
  ArvStream* Stream() const { return stream_; }  // null: none was taken
  void TakeStream(ArvStream* stream) { stream_ = stream; }
  // Keeps `thing` alive until the stream has been released.
  void KeepBeyondStream(std::shared_ptr<void> thing) { beyond_stream_ = std::move(thing); }
  void ReleaseStream() {
    g_clear_object(&stream_);
    beyond_stream_.reset();
  }
  // Returns null for an empty name or a feature that the camera does not have.
  ArvGcNode* Node(const std::string& feature) const;
  // Returns whether the camera has the feature and the feature is available now.
  bool Has(const std::string& feature) const;
  // Returns the choices of an enumeration that are available now.
  std::vector<std::string> Choices(const std::string& enumeration) const;
  bool ControlLost() const { return control_lost_.load(); }
  bool IsController() const;  // whether this program controls the camera; true on USB
  // Returns "another program controls this camera, from 192.0.2.5; close it ...", for error messages.
  std::string WhoControls() const;
  // Returns the IPv4 address; empty for a camera on another bus.
  std::string GigeAddress() const;
  bool IsUsb() const;
  // Returns whether a USB3 Vision camera answers a question; takes half a second where it does not.
  bool UsbAnswers() const;
  // Fills in maker, model, serial, address and bus.
  void Describe(DeviceInfo& info) const;

 private:
  static void OnControlLost(ArvDevice* device, gpointer self);

  ArvCamera* camera_;
  ArvStream* stream_ = nullptr;
  std::shared_ptr<void> beyond_stream_;
  gulong handler_ = 0;
  std::atomic<bool> control_lost_{false};
  std::atomic<int> inside_handler_{0};
};

}  // namespace ulf::acquisition
