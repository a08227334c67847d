#include "acquisition/gphoto2/gphoto_camera.h"

#include <fmt/format.h>
#include <gphoto2/gphoto2-port-log.h>
#include <gphoto2/gphoto2.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "acquisition/device/device_files.h"
#include "acquisition/gphoto2/ptpip_descriptors.h"
#include "core/base/error.h"
#include "core/base/mutex.h"

namespace ulf::acquisition {
namespace {

// Blocks SIGPIPE in this thread, which a write into a broken connection sends, and removes it afterwards.
class WithoutSigpipe {
 public:
  WithoutSigpipe() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    was_pending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~WithoutSigpipe() {
    const timespec at_once{};
    if (!was_pending_)
      while (sigtimedwait(&pipe_, nullptr, &at_once) == SIGPIPE) continue;
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  WithoutSigpipe(const WithoutSigpipe&) = delete;
  WithoutSigpipe& operator=(const WithoutSigpipe&) = delete;

 private:
  sigset_t pipe_, before_;
  bool was_pending_ = false;
};

// An answer that comes too late leaves a PTP/IP connection out of step: the library takes it for the answer
// to the next request, and so on for all that follow, so that photographs come without names and settings
// with other values. The library (2.5.30) reports this in its log only. A refusal is no such case.
thread_local bool answers_are_out_of_step = false;

void OnLibraryError(GPLogLevel /*level*/, const char* function, const char* text, void* /*none*/) {
  const std::string_view words(text);
  const bool is_closed = words.starts_with("End of stream");  // results report that
  if (std::string_view(function).starts_with("ptp_ptpip_") && !is_closed &&
      !words.starts_with("Unexpected ptp response"))
    answers_are_out_of_step = true;
}

template <typename T, auto Release>
struct Releaser {
  void operator()(T* thing) const { Release(thing); }
};
using Abilities = std::unique_ptr<CameraAbilitiesList, Releaser<CameraAbilitiesList, gp_abilities_list_free>>;
using Ports = std::unique_ptr<GPPortInfoList, Releaser<GPPortInfoList, gp_port_info_list_free>>;
using Widget = std::unique_ptr<CameraWidget, Releaser<CameraWidget, gp_widget_free>>;
using File = std::unique_ptr<CameraFile, Releaser<CameraFile, gp_file_unref>>;
using Context = std::unique_ptr<GPContext, Releaser<GPContext, gp_context_unref>>;
using List = std::unique_ptr<CameraList, Releaser<CameraList, gp_list_unref>>;

// Held while a camera is opened or closed, which loads or unloads drivers: no two threads may do that at
// once.
Mutex library_mutex;
// Returns the list of drivers, read from disk once, which takes a tenth of a second.
CameraAbilitiesList* AllAbilities(GPContext* context) ULF_REQUIRES(library_mutex) {
  static const Abilities all = [&] {
    CameraAbilitiesList* list = nullptr;
    gp_abilities_list_new(&list);
    gp_abilities_list_load(list, context);
    return Abilities(list);
  }();
  return all.get();
}

Ports NewPorts() {
  GPPortInfoList* list = nullptr;
  gp_port_info_list_new(&list);
  gp_port_info_list_load(list);
  return Ports(list);
}

FeatureType TypeOf(CameraWidgetType type) {
  switch (type) {
    case GP_WIDGET_RADIO:
    case GP_WIDGET_MENU:
      return FeatureType::kEnumeration;
    case GP_WIDGET_RANGE:
      return FeatureType::kFloat;
    case GP_WIDGET_TOGGLE:
      return FeatureType::kBoolean;
    case GP_WIDGET_DATE:
      return FeatureType::kInteger;
    case GP_WIDGET_BUTTON:
      return FeatureType::kCommand;
    default:
      return FeatureType::kString;
  }
}

std::string OrEmpty(const char* text) { return text ? text : ""; }

CameraFeature SettingOf(CameraWidget* widget, const std::string& category) {
  CameraFeature setting;
  setting.category = category;
  const char* text = nullptr;
  gp_widget_get_name(widget, &text);
  setting.name = OrEmpty(text);
  text = nullptr;
  gp_widget_get_label(widget, &text);
  setting.description = OrEmpty(text);
  CameraWidgetType type = GP_WIDGET_TEXT;
  gp_widget_get_type(widget, &type);
  setting.type = TypeOf(type);
  int read_only = 0;
  gp_widget_get_readonly(widget, &read_only);
  // libgphoto2 runs buttons by its own callbacks, so they cannot be written.
  setting.read_only = type == GP_WIDGET_BUTTON;
  setting.readable = !setting.read_only;
  setting.writable = read_only == 0 && !setting.read_only;
  if (type == GP_WIDGET_DATE) setting.unit = "s since 1970";
  switch (setting.type) {
    case FeatureType::kEnumeration:
      for (int i = 0; i < gp_widget_count_choices(widget); ++i) {
        const char* choice = nullptr;
        gp_widget_get_choice(widget, i, &choice);
        setting.choices.push_back(OrEmpty(choice));
      }
      [[fallthrough]];
    case FeatureType::kString: {
      const char* value = nullptr;
      gp_widget_get_value(widget, &value);
      setting.value = OrEmpty(value);
      break;
    }
    case FeatureType::kFloat: {
      float value = 0, min = 0, max = 0, step = 0;
      gp_widget_get_value(widget, &value);
      gp_widget_get_range(widget, &min, &max, &step);
      setting.min = min;
      setting.max = max;
      if (step > 0) setting.step = step;
      setting.value = fmt::format("{}", value);
      break;
    }
    case FeatureType::kBoolean:
    case FeatureType::kInteger: {
      int value = 0;
      gp_widget_get_value(widget, &value);
      setting.value = std::to_string(value);
      break;
    }
    case FeatureType::kCommand:
      break;
  }
  return setting;
}

bool Write(CameraWidget* widget, FeatureType type, const std::string& value) {
  switch (type) {
    case FeatureType::kEnumeration:
    case FeatureType::kString:
      return gp_widget_set_value(widget, value.c_str()) == GP_OK;
    case FeatureType::kFloat: {
      const float number = std::strtof(value.c_str(), nullptr);
      return gp_widget_set_value(widget, &number) == GP_OK;
    }
    case FeatureType::kBoolean:
    case FeatureType::kInteger: {
      const int number = std::atoi(value.c_str());
      return gp_widget_set_value(widget, &number) == GP_OK;
    }
    case FeatureType::kCommand:
      return false;
  }
  return false;
}

void Collect(CameraWidget* widget, const std::string& category, std::vector<CameraFeature>& settings) {
  CameraWidgetType type = GP_WIDGET_TEXT;
  gp_widget_get_type(widget, &type);
  if (type != GP_WIDGET_WINDOW && type != GP_WIDGET_SECTION) {
    settings.push_back(SettingOf(widget, category));
    return;
  }
  std::string below = category;
  if (type == GP_WIDGET_SECTION) {
    const char* name = nullptr;
    gp_widget_get_name(widget, &name);
    if (!below.empty()) below += "/";
    below += OrEmpty(name);
  }
  for (int i = 0; i < gp_widget_count_children(widget); ++i) {
    CameraWidget* child = nullptr;
    if (gp_widget_get_child(widget, i, &child) == GP_OK) Collect(child, below, settings);
  }
}

std::string UsbNode(const std::string& port, const std::string& usb) {
  const std::size_t colon = port.find(':'), comma = port.find(',');
  if (!port.starts_with("usb:") || comma == std::string::npos) return {};
  return fmt::format("{}/{}/{}", usb, port.substr(colon + 1, comma - colon - 1), port.substr(comma + 1));
}

}  // namespace

bool GphotoResult::Busy() const { return code == GP_ERROR_CAMERA_BUSY; }
// The ptp2 driver reports a full card only in its text.
bool GphotoResult::CardFull() const {
  return code == GP_ERROR_NO_SPACE || text.find("Store Full") != std::string::npos;
}
bool GphotoResult::NotSupported() const { return code == GP_ERROR_NOT_SUPPORTED; }
bool GphotoResult::NoSuchFile() const {
  return code == GP_ERROR_FILE_NOT_FOUND || code == GP_ERROR_DIRECTORY_NOT_FOUND;
}
bool GphotoResult::LinkIsGone() const {
  return code == GP_ERROR_IO || (code <= GP_ERROR_IO_INIT && code >= GP_ERROR_IO_LOCK) ||
         code == GP_ERROR_MODEL_NOT_FOUND;
}

struct GphotoCamera::State {
  const bool is_ptpip;
  Context context;
  Camera* camera = nullptr;
  PtpipDescriptors descriptors;
  std::string said;  // the driver's messages since the last call began
  bool out_of_step = false;

  static void OnError(GPContext* /*context*/, const char* text, void* self) {
    std::string& said = static_cast<State*>(self)->said;
    if (!said.empty()) said += "; ";
    said += OrEmpty(text);
  }

  explicit State(const std::string& port)
      : is_ptpip(port.starts_with("ptpip:")), context(gp_context_new()), descriptors(port) {
    static const int listening = gp_log_add_func(GP_LOG_ERROR, OnLibraryError, nullptr);
    static_cast<void>(listening);
    gp_context_set_error_func(context.get(), &State::OnError, this);
    gp_camera_new(&camera);
  }
  ~State() {
    const WithoutSigpipe guard;
    const MutexLock lock(library_mutex);
    descriptors.Close([this] {
      gp_camera_exit(camera, context.get());
      gp_camera_unref(camera);
    });
  }

  template <typename Call>
  GphotoResult Do(Call&& call) {
    const WithoutSigpipe guard;
    said.clear();
    answers_are_out_of_step = false;
    GphotoResult result;
    result.code = call(camera, context.get());
    out_of_step |= is_ptpip && (answers_are_out_of_step || result.code == GP_ERROR_TIMEOUT);
    if (result.code < 0) {
      result.text = OrEmpty(gp_result_as_string(result.code));
      if (!said.empty()) result.text += ": " + said;
    }
    return result;
  }

  // Runs a call that fills a file of the library, and copies its bytes.
  template <typename Call>
  GphotoResult Fetch(std::string& bytes, Call&& call) {
    return Do([&](Camera* of_camera, GPContext* of_context) {
      CameraFile* raw = nullptr;
      gp_file_new(&raw);
      const File file(raw);
      const int result = call(of_camera, raw, of_context);
      const char* data = nullptr;
      unsigned long size = 0;
      if (result >= 0 && gp_file_get_data_and_size(raw, &data, &size) >= 0 && data) bytes.assign(data, size);
      return result;
    });
  }
};

std::vector<GphotoAddress> DetectGphotoCameras() {
  const WithoutSigpipe guard;
  const MutexLock lock(library_mutex);
  const Context context(gp_context_new());
  CameraList* raw = nullptr;
  gp_list_new(&raw);
  const List list(raw);
  std::vector<GphotoAddress> found;
  if (gp_camera_autodetect(list.get(), context.get()) < 0) return found;
  for (int i = 0; i < gp_list_count(list.get()); ++i) {
    const char *model = nullptr, *port = nullptr;
    gp_list_get_name(list.get(), i, &model);
    gp_list_get_value(list.get(), i, &port);
    // "disk:" is a mounted card, not a camera.
    if (OrEmpty(port).starts_with("usb:")) found.push_back({OrEmpty(model), OrEmpty(port)});
  }
  return found;
}

GphotoCamera::GphotoCamera(const std::string& uri, const GphotoAddress& address)
    : state_(std::make_unique<State>(address.port)) {
  {
    const WithoutSigpipe guard;
    const MutexLock lock(library_mutex);
    CameraAbilitiesList* all = AllAbilities(state_->context.get());
    const int model = gp_abilities_list_lookup_model(all, address.model.c_str());
    if (model < 0)
      throw Error("{}: libgphoto2 has no driver for '{}'; install its drivers (libgphoto2-6)", uri,
                  address.model);
    CameraAbilities abilities;
    gp_abilities_list_get_abilities(all, model, &abilities);
    gp_camera_set_abilities(state_->camera, abilities);
    const Ports ports = NewPorts();
    const int port = gp_port_info_list_lookup_path(ports.get(), address.port.c_str());
    if (port < 0)
      throw Error("{}: there is no port '{}'; 'ulf devices' lists the cameras at USB ports", uri,
                  address.port);
    GPPortInfo info;
    gp_port_info_list_get_info(ports.get(), port, &info);
    gp_camera_set_port_info(state_->camera, info);
  }
  GphotoResult result;
  {
    const MutexLock lock(library_mutex);
    result = state_->Do(gp_camera_init);
  }
  state_->descriptors.Opened();
  if (result.ok()) return;
  const std::string obstacle = UsbObstacle(address.port);
  throw Error(
      "{}: cannot be opened ({}){}", uri, result.text,
      !obstacle.empty() ? ": " + obstacle
      : address.port.starts_with("ptpip:")
          ? "; check that the camera's network mode is on, its address, and that no other computer is "
            "connected to it"
          : "; switch the camera off and on, and check the cable");
}

GphotoCamera::~GphotoCamera() = default;

bool GphotoCamera::OutOfStep() const { return state_->out_of_step; }

std::optional<CameraFeature> GphotoCamera::Setting(const std::string& name) {
  CameraWidget* raw = nullptr;
  const GphotoResult result = state_->Do([&](Camera* camera, GPContext* context) {
    return gp_camera_get_single_config(camera, name.c_str(), &raw, context);
  });
  const Widget widget(raw);
  if (!result.ok() || !widget) return std::nullopt;
  return SettingOf(widget.get(), "");
}

std::vector<CameraFeature> GphotoCamera::Settings() {
  CameraWidget* raw = nullptr;
  std::vector<CameraFeature> settings;
  state_->Do([&](Camera* camera, GPContext* context) { return gp_camera_get_config(camera, &raw, context); });
  const Widget root(raw);
  if (root) Collect(root.get(), "", settings);
  return settings;
}

GphotoResult GphotoCamera::Set(const std::string& name, const std::string& value) {
  return state_->Do([&](Camera* camera, GPContext* context) {
    CameraWidget* raw = nullptr;
    const int got = gp_camera_get_single_config(camera, name.c_str(), &raw, context);
    const Widget widget(raw);
    if (got < 0) return got;
    CameraWidgetType type = GP_WIDGET_TEXT;
    gp_widget_get_type(widget.get(), &type);
    if (!Write(widget.get(), TypeOf(type), value)) return GP_ERROR_BAD_PARAMETERS;
    return gp_camera_set_single_config(camera, name.c_str(), widget.get(), context);
  });
}

GphotoResult GphotoCamera::LiveView(std::string& jpeg) {
  return state_->Fetch(jpeg, [](Camera* camera, CameraFile* file, GPContext* context) {
    return gp_camera_capture_preview(camera, file, context);
  });
}

GphotoResult GphotoCamera::ReleaseShutter() { return state_->Do(gp_camera_trigger_capture); }

GphotoResult GphotoCamera::WaitForEvent(int timeout_ms, GphotoEvent& event) {
  event = {};
  return state_->Do([&](Camera* camera, GPContext* context) {
    CameraEventType type = GP_EVENT_TIMEOUT;
    void* data = nullptr;
    const int result = gp_camera_wait_for_event(camera, timeout_ms, &type, &data, context);
    const std::unique_ptr<void, Releaser<void, std::free>> owned(data);
    if (result < 0) return result;
    if (type == GP_EVENT_FILE_ADDED && data) {
      const auto* path = static_cast<const CameraFilePath*>(data);
      event.kind = GphotoEventKind::kFileAdded;
      event.file = {path->folder, path->name};
    } else if (type != GP_EVENT_TIMEOUT) {
      event.kind = GphotoEventKind::kOther;
      if (type == GP_EVENT_UNKNOWN && data) event.text = static_cast<const char*>(data);
    }
    return result;
  });
}

GphotoResult GphotoCamera::Download(const GphotoFile& from, std::string& bytes) {
  return state_->Fetch(bytes, [&](Camera* camera, CameraFile* file, GPContext* context) {
    return gp_camera_file_get(camera, from.folder.c_str(), from.name.c_str(), GP_FILE_TYPE_NORMAL, file,
                              context);
  });
}

GphotoResult GphotoCamera::Delete(const GphotoFile& file) {
  return state_->Do([&](Camera* camera, GPContext* context) {
    return gp_camera_file_delete(camera, file.folder.c_str(), file.name.c_str(), context);
  });
}

GphotoResult GphotoCamera::FilesIn(const std::string& folder, std::vector<std::string>& names) {
  names.clear();
  return state_->Do([&](Camera* camera, GPContext* context) {
    CameraList* raw = nullptr;
    gp_list_new(&raw);
    const List list(raw);
    const int result = gp_camera_folder_list_files(camera, folder.c_str(), list.get(), context);
    for (int i = 0; result >= 0 && i < gp_list_count(list.get()); ++i) {
      const char* name = nullptr;
      if (gp_list_get_name(list.get(), i, &name) >= 0) names.push_back(OrEmpty(name));
    }
    return result;
  });
}

GphotoResult GphotoCamera::WrittenAt(const GphotoFile& file, std::optional<double>& time_s) {
  time_s.reset();
  return state_->Do([&](Camera* camera, GPContext* context) {
    CameraFileInfo info{};
    const int result =
        gp_camera_file_get_info(camera, file.folder.c_str(), file.name.c_str(), &info, context);
    if (result >= 0 && (info.file.fields & GP_FILE_INFO_MTIME) && info.file.mtime > 0)
      time_s = static_cast<double>(info.file.mtime);
    return result;
  });
}

GphotoResult GphotoCamera::Storages(std::vector<GphotoStorage>& storages) {
  storages.clear();
  return state_->Do([&](Camera* camera, GPContext* context) {
    CameraStorageInformation* raw = nullptr;
    int count = 0;
    const int result = gp_camera_get_storageinfo(camera, &raw, &count, context);
    const std::unique_ptr<CameraStorageInformation, Releaser<void, std::free>> infos(raw);
    for (int i = 0; result >= 0 && i < count; ++i) {
      const CameraStorageInformation& info = raw[i];
      GphotoStorage storage;
      storage.is_card =
          (info.fields & GP_STORAGEINFO_STORAGETYPE) && info.type == GP_STORAGEINFO_ST_REMOVABLE_RAM;
      storage.is_full = ((info.fields & GP_STORAGEINFO_FREESPACEIMAGES) && info.freeimages == 0) ||
                        ((info.fields & GP_STORAGEINFO_FREESPACEKBYTES) && info.freekbytes == 0);
      storages.push_back(storage);
    }
    return result;
  });
}

std::vector<std::string> ProgramsHoldingUsb(const std::string& port, const std::string& proc,
                                            const std::string& usb) {
  const std::string node = UsbNode(port, usb);
  return node.empty() ? std::vector<std::string>{} : ProgramsHolding(node, proc);
}

std::string UsbObstacle(const std::string& port) {
  const std::string node = UsbNode(port, "/dev/bus/usb");
  if (node.empty()) return {};
  if (access(node.c_str(), F_OK) == 0 && access(node.c_str(), W_OK) != 0)
    return fmt::format(
        "this user may not write to {}; install the rules in udev/ (see docs/devices.md) and plug the camera "
        "in again",
        node);
  const std::vector<std::string> programs = ProgramsHolding(node);
  if (programs.empty()) return {};
  const std::string holders = fmt::format("{}", fmt::join(programs, ", "));
  if (std::any_of(programs.begin(), programs.end(),
                  [](const std::string& program) { return program.starts_with("gvfs"); }))
    return fmt::format(
        "the desktop has mounted it ({} uses it); release it with 'gio mount -s gphoto2' or by ejecting it "
        "in the file manager",
        holders);
  return fmt::format("{} uses it; close that program", holders);
}

}  // namespace ulf::acquisition
