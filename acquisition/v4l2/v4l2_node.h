// Opens a Video4Linux2 node (/dev/video0), calls its driver (linux/videodev2.h), and identifies the camera.
#pragma once

#include <linux/videodev2.h>

#include <string>
#include <vector>

#include "acquisition/device/device.h"
#include "core/base/file_descriptor.h"

namespace ulf::acquisition {

class V4l2Node {
 public:
  // Throws Error that names the node and the reason: missing, no permission, in use (by which program).
  explicit V4l2Node(const std::string& path);

  const std::string& Path() const { return path_; }
  int Number() const { return file_.Number(); }  // of the open file
  // Calls the driver (ioctl). Returns 0, or the error number. Never blocks.
  int Call(unsigned long request, void* argument) const;
  // Throws Error that names the node and the failed action; for EBUSY also the program that streams.
  [[noreturn]] void Throw(const char* what, int error) const;
  void CallOrThrow(const char* what, unsigned long request, void* argument) const;

 private:
  std::string path_;
  FileDescriptor file_;
};

// Returns the text in a field of fixed size, with or without a terminating zero.
std::string V4l2Text(const unsigned char* field, std::size_t size);

// Returns a message for an errno of the node's, with the remedy.
std::string V4l2Problem(const std::string& path, int error);

// The camera of a node. `info.serial`: the USB serial number, may be empty; `info.bus`: its port.
struct V4l2Camera {
  DeviceInfo info;
  std::string node;      // "/dev/video0"
  std::string bus_info;  // "usb-0000:00:14.0-1"
};

// Returns every node that captures pictures, in the order of the numbers; nodes that cannot be opened are
// included with the reason, nodes for metadata and other purposes are not.
std::vector<V4l2Camera> FindV4l2Cameras();

// Returns the camera for a URI's path: a node, a serial number, a bus path or a camera's name; for an empty
// path the first that can be opened. Throws Error that lists the cameras if none or several match.
V4l2Camera ResolveV4l2Camera(const std::string& uri, const std::string& path);

}  // namespace ulf::acquisition
