// Keeps this process's files from a mistake of libgphoto2's (2.5.30): closing a PTP/IP camera, it closes
// descriptor 0, whatever that is by then (standard input; where that was closed, perhaps the journal of a
// capture), and leaves its own two connections open, so that the camera waits for ever and accepts nobody
// else.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace ulf {

// The descriptors of this process that are connected to that address ("192.168.1.9") and TCP port.
std::vector<int> ConnectionsTo(const std::string& host, int port);

// A second name for descriptor 0 while it may be closed. Given back only if the number is free: what another
// thread has opened under it meanwhile is that thread's.
class KeepsDescriptorZero {
 public:
  KeepsDescriptorZero();
  ~KeepsDescriptorZero();
  KeepsDescriptorZero(const KeepsDescriptorZero&) = delete;
  KeepsDescriptorZero& operator=(const KeepsDescriptorZero&) = delete;

 private:
  int saved_;
};

class PtpipDescriptors {
 public:
  // From before the camera is opened. `port` as "ptpip:ADDRESS:PORT:PORT"; with anything else nothing is
  // done.
  explicit PtpipDescriptors(const std::string& port);
  // Which connections the library has made since.
  void Opened();
  // Runs what closes the camera, unless descriptor 0 has become somebody else's file (then the library keeps
  // its memory, no more); closes the camera's connections.
  void Close(const std::function<void()>& close_camera);

 private:
  bool is_ptpip_ = false;
  std::string host_;
  int port_ = 0;
  std::vector<int> before_, connections_;
  unsigned long long device_ = 0, inode_ = 0;  // of descriptor 0
};

}  // namespace ulf
