// One tethered camera as libgphoto2 drives it, with values instead of that library's handles.
//
// The library is not made for threads: whoever owns a GphotoCamera makes every call to it from one thread at
// a time (gphoto_device.h gives it a thread of its own). A connection that breaks makes the library write
// into a closed socket: every call here keeps SIGPIPE from the process, whoever the process belongs to.
//
// What a camera answers (busy, no card, gone) is a value; what cannot be opened throws Error with the way
// out.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ulf::acquisition {

struct GphotoResult {
  int code = 0;
  std::string text;  // the library's words, with the driver's own behind them
  bool ok() const { return code >= 0; }
  bool Busy() const;
  bool CardFull() const;
  bool NotSupported() const;
  bool NoSuchFile() const;
  bool LinkIsGone() const;  // by the code alone
};

enum class GphotoSettingType { kChoice, kText, kRange, kToggle, kDate, kButton };

struct GphotoSetting {
  std::string name;      // "shutterspeed"
  std::string category;  // "capturesettings"
  std::string label;
  GphotoSettingType type = GphotoSettingType::kText;
  std::string
      value;  // toggles: "0", "1", or "2" when the camera does not say; dates: seconds since the epoch
  std::vector<std::string> choices;
  double min = 0, max = 0, step = 0;  // of a range
  bool read_only = false;
};

struct GphotoFile {
  std::string folder, name;
};

enum class GphotoEventKind { kNothing, kFileAdded, kOther };
struct GphotoEvent {
  GphotoEventKind kind = GphotoEventKind::kNothing;
  GphotoFile file;
  std::string text;  // of kOther: the driver's words, as "PTP Property 500f changed"
};

struct GphotoStorage {
  bool is_card = false;
  bool is_full = false;
};

// Where a camera is: the driver's name for it and its port ("usb:001,005", "ptpip:192.168.1.9:15740:15740").
struct GphotoAddress {
  std::string model, port;
  bool operator==(const GphotoAddress&) const = default;
};

// Cameras at the USB ports; network ones do not announce themselves.
std::vector<GphotoAddress> DetectGphotoCameras();

class GphotoCamera {
 public:
  // `uri` is for the words of errors.
  GphotoCamera(const std::string& uri, const GphotoAddress& address);
  ~GphotoCamera();
  GphotoCamera(const GphotoCamera&) = delete;
  GphotoCamera& operator=(const GphotoCamera&) = delete;

  std::optional<GphotoSetting> Setting(const std::string& name);  // none: the camera has none of that name
  std::vector<GphotoSetting> Settings();                          // the whole tree; a second or more
  GphotoResult Set(const std::string& name, const std::string& value);

  GphotoResult LiveView(std::string& jpeg);
  GphotoResult ReleaseShutter();  // returns before the photograph is there
  GphotoResult WaitForEvent(int timeout_ms, GphotoEvent& event);
  GphotoResult Download(const GphotoFile& file, std::string& bytes);
  GphotoResult Delete(const GphotoFile& file);
  // Answers of a network camera no longer belong to the questions, whatever results say: to be opened anew.
  bool OutOfStep() const;
  GphotoResult Storages(std::vector<GphotoStorage>& storages);  // asks the camera itself: also a sign of life

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The programs that hold a USB camera open, by name ("gvfsd-gphoto2 (process 812)"), as far as this user may
// see them; `port` as "usb:001,005".
std::vector<std::string> ProgramsHoldingUsb(const std::string& port, const std::string& proc = "/proc",
                                            const std::string& usb = "/dev/bus/usb");
// Why a USB camera cannot be opened, with the way out; empty when nothing is known against it.
std::string UsbObstacle(const std::string& port);

}  // namespace ulf::acquisition
