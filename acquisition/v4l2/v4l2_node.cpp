#include "acquisition/v4l2/v4l2_node.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

#include "acquisition/device/device_files.h"
#include "core/base/error.h"

namespace ulf::acquisition {
namespace {

namespace fs = std::filesystem;

constexpr const char* kClass = "/sys/class/video4linux";

// Returns the first line of a file in /sys; empty where there is none.
std::string Line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::string RealPath(const std::string& path) {
  std::error_code missing;
  return std::filesystem::canonical(path, missing).string();
}

std::string PermissionProblem(const std::string& path) {
  struct stat status {};
  std::string group = "video";
  if (stat(path.c_str(), &status) == 0)
    if (const ::group* entry = getgrgid(status.st_gid)) group = entry->gr_name;
  return fmt::format(
      "no permission to open {}, which belongs to the group {}: add yourself to it (sudo usermod -aG {} "
      "$USER, then log in again), or install udev/70-ulf-cameras.rules, which lets the user at this computer "
      "open it",
      path, group, group);
}

int Number(const std::string& node_name) {  // "video12"
  return std::atoi(node_name.c_str() + std::string_view("video").size());
}

// Returns the folder of the USB device above a node's folder in /sys; empty where it is not a USB device.
std::string UsbFolder(fs::path folder) {
  for (; folder.has_relative_path(); folder = folder.parent_path())
    if (!Line(folder / "idVendor").empty()) return folder;
  return "";
}

std::optional<V4l2Camera> Describe(const std::string& name) {
  V4l2Camera camera;
  camera.node = "/dev/" + name;
  camera.info.uri = "v4l2:" + camera.node;
  camera.info.model = Line(std::string(kClass) + "/" + name + "/name");
  camera.info.bus = "V4L2";
  const std::string usb = UsbFolder(RealPath(std::string(kClass) + "/" + name));
  if (!usb.empty()) {
    camera.info.maker = Line(usb + "/manufacturer");
    camera.info.serial = Line(usb + "/serial");
    if (const std::string product = Line(usb + "/product"); !product.empty()) camera.info.model = product;
  }
  try {
    const V4l2Node node(camera.node);
    v4l2_capability capability{};
    if (node.Call(VIDIOC_QUERYCAP, &capability) != 0) return std::nullopt;
    const std::uint32_t can =
        capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
    if (!(can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE))) return std::nullopt;
    camera.bus_info = V4l2Text(capability.bus_info, sizeof capability.bus_info);
    if (camera.info.model.empty()) camera.info.model = V4l2Text(capability.card, sizeof capability.card);
    if (!(can & V4L2_CAP_VIDEO_CAPTURE))
      camera.info.problem =
          "its pictures come in several planes, which ulf does not read; use the node of the image processor "
          "behind it, if it has one";
    else if (!(can & V4L2_CAP_STREAMING))
      camera.info.problem = "its driver does not stream; ulf needs a driver that does";
  } catch (const Error& error) {
    camera.info.problem = error.what();
  }
  if (!camera.bus_info.empty()) camera.info.bus = camera.bus_info;
  camera.info.available = camera.info.problem.empty();
  return camera;
}

}  // namespace

std::string V4l2Text(const unsigned char* field, std::size_t size) {
  const char* text = reinterpret_cast<const char*>(field);
  return std::string(text, strnlen(text, size));
}

std::string V4l2Problem(const std::string& path, int error) {
  switch (error) {
    case ENOENT:
      return fmt::format("there is no {}; 'ulf devices' lists the cameras in reach", path);
    case EACCES:
    case EPERM:
      return PermissionProblem(path);
    case EBUSY: {
      const std::vector<std::string> who = ProgramsHolding(path);
      return fmt::format(
          "another program streams from {}{}; close it and try again", path,
          who.empty() ? " ('fuser -v " + path + "' tells which)" : fmt::format(": {}", fmt::join(who, ", ")));
    }
    case ENODEV:
    case ENXIO:
      return fmt::format("{} is no longer there: the camera was unplugged or lost power; plug it in again",
                         path);
    case ENOSPC:
      return fmt::format(
          "the USB bus of {} has no room for this picture size and frame rate; choose less (?size=640x480), "
          "format=MJPEG, or another USB socket",
          path);
    default:
      return fmt::format("{}: {}", path, std::strerror(error));
  }
}

V4l2Node::V4l2Node(const std::string& path)
    : path_(path), file_(open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
  if (!file_.IsOpen()) throw Error("{}", V4l2Problem(path, errno));
}

int V4l2Node::Call(unsigned long request, void* argument) const {
  int result = 0;
  do result = ioctl(Number(), request, argument);
  while (result < 0 && errno == EINTR);
  return result < 0 ? errno : 0;
}

void V4l2Node::Throw(const char* what, int error) const {
  if (error == EBUSY || error == ENODEV || error == ENOSPC)
    throw Error("{}: {}", what, V4l2Problem(path_, error));
  throw Error("{}: the driver refuses the {}: {}", path_, what, std::strerror(error));
}

void V4l2Node::CallOrThrow(const char* what, unsigned long request, void* argument) const {
  if (const int error = Call(request, argument); error != 0) Throw(what, error);
}

std::vector<V4l2Camera> FindV4l2Cameras() {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(kClass, none))
    if (const std::string name = entry.path().filename(); name.starts_with("video")) names.push_back(name);
  std::sort(names.begin(), names.end(),
            [](const std::string& a, const std::string& b) { return Number(a) < Number(b); });
  std::vector<V4l2Camera> cameras;
  for (const std::string& name : names)
    if (auto camera = Describe(name)) cameras.push_back(std::move(*camera));
  return cameras;
}

V4l2Camera ResolveV4l2Camera(const std::string& uri, const std::string& path) {
  const std::vector<V4l2Camera> cameras = FindV4l2Cameras();
  const std::string node = path.starts_with("/") ? RealPath(path) : "";
  std::string list;
  std::vector<const V4l2Camera*> matching;
  for (const V4l2Camera& camera : cameras) {
    list += fmt::format("{}{} ({} {}, {})", list.empty() ? "" : "; ", camera.node, camera.info.maker,
                        camera.info.model, camera.info.serial);
    const bool is_named = path.empty()
                              ? camera.info.available
                              : path == camera.node || node == camera.node || path == camera.info.serial ||
                                    path == camera.bus_info || path == camera.info.model;
    if (is_named) matching.push_back(&camera);
  }
  if (matching.empty() && !node.empty()) {
    const V4l2Node opened(node);  // throws where the node cannot be opened
    throw Error("{}: {} is not a camera that captures pictures; found: {}", uri, path,
                list.empty() ? "none" : list);
  }
  if (matching.empty() && path.starts_with("/")) throw Error("{}: {}", uri, V4l2Problem(path, ENOENT));
  if (matching.empty())
    throw Error("{}: no webcam {}; found: {}", uri, path.empty() ? "can be used" : "is called '" + path + "'",
                list.empty() ? "none" : list);
  // One camera may have several nodes; they share its serial.
  for (const V4l2Camera* other : matching)
    if (!path.empty() && other->bus_info != matching.front()->bus_info)
      throw Error("{}: '{}' names more than one camera; give a node: {}", uri, path, list);
  if (!matching.front()->info.available) throw Error("{}: {}", uri, matching.front()->info.problem);
  return *matching.front();
}

}  // namespace ulf::acquisition
