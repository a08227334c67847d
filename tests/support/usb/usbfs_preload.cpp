// A library to be preloaded: opening /dev/bus/usb/BBB/DDD reaches an emulated node (usb_node.h) in this
// process or another where there is one, and its ioctls are answered there. Everything else goes on to the
// next library (umockdev's, which stands in for sysfs and udev) and the system.
//
// Why not umockdev's own emulation of ioctls: there a USB node is a plain file, which poll() calls ready at
// all times, so that libusb would ask without a pause, and which cannot tell that its device is gone. The
// file that is handed out here is one end of a pair of sockets, which the node makes ready and breaks as the
// kernel does.
#include <dlfcn.h>
#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "tests/support/usb/usbfs_wire.h"

namespace {

namespace usbfs = ulf::test::usbfs;

// By file. Where it is not open, another thread may still be about to use it.
struct OpenNode {
  std::atomic<bool> is_open = false;
  std::mutex mutex;
  int control = -1;
};

constexpr int kMostFiles = 4096;
std::array<OpenNode, kMostFiles> nodes{};

template <typename Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
int NextClose(int file) {
  static const auto next = Next<int (*)(int)>("close");
  return next(file);
}

// The file that the node hands out; -1 with errno where it refuses.
int ReceiveFile(int control) {
  usbfs::Reply reply;
  iovec part{&reply, sizeof reply};
  alignas(cmsghdr) char room[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = room;
  message.msg_controllen = sizeof room;
  if (recvmsg(control, &message, MSG_CMSG_CLOEXEC | MSG_WAITALL) != static_cast<ssize_t>(sizeof reply)) {
    errno = ENODEV;
    return -1;
  }
  const cmsghdr* header = CMSG_FIRSTHDR(&message);
  if (reply.error != 0 || !header) {
    errno = reply.error ? reply.error : ENODEV;
    return -1;
  }
  int file = -1;
  std::memcpy(&file, CMSG_DATA(header), sizeof file);
  return file;
}

// Whether there is an emulated node of that path; then `result` is what open() returns.
bool OpensNode(const char* path, int& result) {
  const char* folder = getenv(usbfs::kFolderVariable);
  int bus = 0, number = 0;
  if (!folder || !path || std::sscanf(path, "/dev/bus/usb/%d/%d", &bus, &number) != 2) return false;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::snprintf(address.sun_path, sizeof address.sun_path, "%s/%03d-%03d", folder, bus, number);
  const int control = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (control < 0) return false;
  if (connect(control, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    NextClose(control);
    return false;  // there is none, or it was just pulled out
  }
  result = ReceiveFile(control);
  if (result >= kMostFiles) {
    NextClose(result);
    result = -1;
    errno = EMFILE;
  }
  if (result < 0) {
    const int reason = errno;
    NextClose(control);
    errno = reason;
    return true;
  }
  OpenNode& node = nodes[static_cast<std::size_t>(result)];
  const std::lock_guard lock(node.mutex);
  node.control = control;
  node.is_open = true;
  return true;
}

OpenNode* NodeOf(int file) {
  if (file < 0 || file >= kMostFiles) return nullptr;
  OpenNode& node = nodes[static_cast<std::size_t>(file)];
  return node.is_open ? &node : nullptr;
}

int Submit(int control, void* argument) {
  const auto* urb = static_cast<const usbdevfs_urb*>(argument);
  const bool is_control = urb->type == USBDEVFS_URB_TYPE_CONTROL;
  const bool to_device =
      is_control ? (static_cast<const unsigned char*>(urb->buffer)[0] & 0x80) == 0 : !(urb->endpoint & 0x80);
  const std::size_t data = to_device    ? static_cast<std::size_t>(urb->buffer_length)
                           : is_control ? std::size_t{8}
                                        : std::size_t{0};
  const usbfs::Urb told{urb->type, urb->endpoint, 0, urb->flags, urb->buffer_length};
  const usbfs::Request request{static_cast<std::uint32_t>(USBDEVFS_SUBMITURB),
                               static_cast<std::uint32_t>(sizeof told + data),
                               reinterpret_cast<std::uint64_t>(argument)};
  return usbfs::SendAll(control, &request, sizeof request) && usbfs::SendAll(control, &told, sizeof told) &&
         usbfs::SendAll(control, urb->buffer, data);
}

int Answer(OpenNode& node, unsigned long number, void* argument) {
  const std::lock_guard lock(node.mutex);
  bool sent = false;
  if (number == USBDEVFS_SUBMITURB) {
    sent = Submit(node.control, argument);
  } else {
    // What the others are told fits in an int, or they get something back.
    usbfs::Request request{static_cast<std::uint32_t>(number), 0, reinterpret_cast<std::uint64_t>(argument)};
    if (number == USBDEVFS_CLAIMINTERFACE || number == USBDEVFS_RELEASEINTERFACE ||
        number == USBDEVFS_CLEAR_HALT || number == USBDEVFS_RESETEP || number == USBDEVFS_GETDRIVER ||
        number == USBDEVFS_DISCONNECT_CLAIM || number == USBDEVFS_SETINTERFACE)
      request.argument = *static_cast<const unsigned*>(argument);
    sent = usbfs::SendAll(node.control, &request, sizeof request);
  }
  usbfs::Reply reply;
  if (!sent || !usbfs::ReceiveAll(node.control, &reply, sizeof reply)) {
    errno = ENODEV;
    return -1;
  }
  if (reply.error == 0 && number == USBDEVFS_GET_CAPABILITIES)
    *static_cast<std::uint32_t*>(argument) = static_cast<std::uint32_t>(reply.urb);
  if (reply.error == 0 && number == USBDEVFS_REAPURBNDELAY) {
    auto* urb = reinterpret_cast<usbdevfs_urb*>(reply.urb);
    if (!usbfs::ReceiveAll(node.control, static_cast<char*>(urb->buffer) + reply.into_at, reply.bytes)) {
      errno = ENODEV;
      return -1;
    }
    urb->status = reply.status;
    urb->actual_length = reply.actual;
    *static_cast<void**>(argument) = urb;
  }
  errno = reply.error;
  return reply.error != 0 ? -1 : reply.result;
}

int OpenOrPass(const char* name, const char* path, int flags, mode_t mode) {
  int result = -1;
  if (OpensNode(path, result)) return result;
  return Next<int (*)(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

// Under names of their own, because the headers declare the real ones in their own ways.
extern "C" {
int UlfOpen(const char* path, int flags, ...) __asm__("open");
int UlfOpen64(const char* path, int flags, ...) __asm__("open64");
int UlfOpen2(const char* path, int flags) __asm__("__open_2");
int UlfOpen642(const char* path, int flags) __asm__("__open64_2");
int UlfClose(int file) __asm__("close");
int UlfIoctl(int file, unsigned long number, ...) __asm__("ioctl");

int UlfOpen(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const auto mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return OpenOrPass("open", path, flags, mode);
}
int UlfOpen64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const auto mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return OpenOrPass("open64", path, flags, mode);
}
int UlfOpen2(const char* path, int flags) { return OpenOrPass("__open_2", path, flags, 0); }
int UlfOpen642(const char* path, int flags) { return OpenOrPass("__open64_2", path, flags, 0); }

int UlfClose(int file) {
  if (OpenNode* node = NodeOf(file)) {
    node->is_open = false;
    const std::lock_guard lock(node->mutex);
    NextClose(node->control);
    node->control = -1;
  }
  return NextClose(file);
}

int UlfIoctl(int file, unsigned long number, ...) {
  va_list more;
  va_start(more, number);
  void* argument = va_arg(more, void*);
  va_end(more);
  if (OpenNode* node = NodeOf(file)) return Answer(*node, number, argument);
  static const auto next = Next<int (*)(int, unsigned long, ...)>("ioctl");
  return next(file, number, argument);
}
}
