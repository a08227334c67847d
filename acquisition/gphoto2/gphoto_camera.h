// Controls one tethered camera through libgphoto2, with values instead of the library's handles.
//
// libgphoto2 is not thread-safe: the owner makes all calls from one thread at a time (GphotoDevice has a
// thread for them). When a connection breaks the library writes into a closed socket; every call here
// therefore blocks SIGPIPE.
//
// Answers of the camera (busy, no card, disconnected) are values; opening it throws Error with the remedy.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/device/features.h"

namespace ulf::acquisition {

struct GphotoResult {
  int code = 0;      // of libgphoto2; negative: an error
  std::string text;  // the message of the library, then that of the driver
  bool ok() const { return code >= 0; }
  bool Busy() const;
  bool CardFull() const;
  bool NotSupported() const;
  bool NoSuchFile() const;
  bool LinkIsGone() const;  // by the code alone
};

struct GphotoFile {
  std::string folder, name;
  std::string Path() const { return folder + "/" + name; }
};

enum class GphotoEventKind { kNothing, kFileAdded, kOther };
struct GphotoEvent {
  GphotoEventKind kind = GphotoEventKind::kNothing;
  GphotoFile file;
  std::string text;  // of kOther: the message of the driver, such as "PTP Property 500f changed"
};

struct GphotoStorage {
  bool is_card = false;
  bool is_full = false;
};

// A camera's model as the driver names it, and its port ("usb:001,005", "ptpip:192.168.1.9:15740:15740").
struct GphotoAddress {
  std::string model, port;
  bool operator==(const GphotoAddress&) const = default;
};

// Lists the cameras at the USB ports; libgphoto2 cannot discover network cameras.
std::vector<GphotoAddress> DetectGphotoCameras();

class GphotoCamera {
 public:
  // Opens the camera. Errors name `uri`.
  GphotoCamera(const std::string& uri, const GphotoAddress& address);
  ~GphotoCamera();
  GphotoCamera(const GphotoCamera&) = delete;
  GphotoCamera& operator=(const GphotoCamera&) = delete;

  // Return one setting ("shutterspeed"), none if the camera has none of that name, and the whole tree of
  // settings, which takes a second or more. The value of a toggle is "0", "1", or "2" if unknown; that of a
  // date is the seconds since the epoch, as an integer.
  std::optional<CameraFeature> Setting(const std::string& name);
  std::vector<CameraFeature> Settings();
  GphotoResult Set(const std::string& name, const std::string& value);

  GphotoResult LiveView(std::string& jpeg);  // the newest frame, as a JPEG file
  GphotoResult ReleaseShutter();             // returns before the photograph is there
  GphotoResult WaitForEvent(int timeout_ms, GphotoEvent& event);
  GphotoResult Download(const GphotoFile& file, std::string& bytes);
  GphotoResult Delete(const GphotoFile& file);
  // Lists the names of all files in a folder of the camera; takes long where there are many.
  GphotoResult FilesIn(const std::string& folder, std::vector<std::string>& names);
  // Reads when the file was written, seconds by the camera's own clock, which may be wrong; none if unknown.
  GphotoResult WrittenAt(const GphotoFile& file, std::optional<double>& time_s);
  // Returns true once answers of a network camera no longer match the requests (PTP transaction ids): the
  // camera must be opened again, whatever the results say.
  bool OutOfStep() const;
  // Asks the camera for its storages, and so whether it still answers.
  GphotoResult Storages(std::vector<GphotoStorage>& storages);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Returns the programs that have a USB camera open ("gvfsd-gphoto2 (process 812)"), as far as this user may
// see them; `port`: such as "usb:001,005".
std::vector<std::string> ProgramsHoldingUsb(const std::string& port, const std::string& proc = "/proc",
                                            const std::string& usb = "/dev/bus/usb");
// Returns why the camera at a USB port cannot be opened, with the remedy; empty if nothing stands in the way.
std::string UsbObstacle(const std::string& port);

}  // namespace ulf::acquisition
