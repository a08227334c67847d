// A video node of the kernel (/dev/video0): opening it with a reason when that fails, calling its driver, and
// who the camera behind it is. Video4Linux2 by its own calls, as linux/videodev2.h has them.
#pragma once

#include <linux/videodev2.h>

#include <string>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

class V4l2Node {
 public:
  // Throws Error naming the node: not there, no permission (which group, which rule), in use (by whom).
  explicit V4l2Node(const std::string& path);
  ~V4l2Node();
  V4l2Node(const V4l2Node&) = delete;
  V4l2Node& operator=(const V4l2Node&) = delete;

  const std::string& Path() const { return path_; }
  int Descriptor() const { return descriptor_; }
  // 0, or the error number. Never waits: the node is open without blocking.
  int Call(unsigned long request, void* argument) const;
  // Throws Error naming the node and what was being done; for EBUSY, who streams.
  [[noreturn]] void Throw(const char* what, int error) const;
  void Must(const char* what, unsigned long request, void* argument) const;

 private:
  std::string path_;
  int descriptor_ = -1;
};

// What went wrong with the node, and the way out.
std::string V4l2Problem(const std::string& path, int error);

// A camera behind a node. `info.serial` is the USB serial number, empty where the camera has none; `info.bus`
// is the place where it is plugged in.
struct V4l2Camera {
  DeviceInfo info;
  std::string node;      // "/dev/video0"
  std::string bus_info;  // "usb-0000:00:14.0-1"
};

// Every node that captures pictures, in order of its number; nodes that cannot be opened are listed with the
// reason, nodes of metadata and of other kinds are not.
std::vector<V4l2Camera> FindV4l2Cameras();

// The node for a URI's path: a node, a serial number, a bus path, a card's name; empty: the first that can be
// opened. Throws Error listing what there is.
V4l2Camera ResolveV4l2Camera(const std::string& uri, const std::string& path);

}  // namespace ulf::acquisition
