// Keeps this process's files from a mistake of libgphoto2's (2.5.30): closing a PTP/IP camera, it closes
// descriptor 0, whatever that is by then (standard input; where that was closed, perhaps a photograph being
// written), and leaves its own two connections open, so that the camera waits for ever and accepts nobody
// else.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace ulf::acquisition {

// A descriptor, and what it stood for when it was looked at: numbers are used again.
struct Connection {
  int descriptor = -1;
  unsigned long long inode = 0;
  bool operator==(const Connection&) const = default;
};

// Those of this process that are connected to that address ("192.168.1.9") and TCP port.
std::vector<Connection> ConnectionsTo(const std::string& host, int port);

// Runs a function in a thread with descriptors of its own: copies of this process's, whose closing nobody
// else notices. False, and nothing was run, where the system does not allow that.
bool RunWithOwnDescriptors(const std::function<void()>& function);

class PtpipDescriptors {
 public:
  // From before the camera is opened. `port` as "ptpip:ADDRESS:PORT:PORT"; with anything else nothing is
  // done.
  explicit PtpipDescriptors(const std::string& port);
  // Which connections the library has made since.
  void Opened();
  // Runs what closes the camera where it can do no harm, and closes the camera's connections.
  void Close(const std::function<void()>& close_camera);

 private:
  bool is_ptpip_ = false;
  std::string host_;
  int port_ = 0;
  std::vector<Connection> before_, connections_;
};

}  // namespace ulf::acquisition
