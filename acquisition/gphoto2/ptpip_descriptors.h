// Works around an error of libgphoto2 2.5.30: when it closes a PTP/IP camera, it closes file descriptor 0
// (standard input, or any file that has this number), and leaves its own two connections open, so that the
// camera accepts no other client.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace ulf::acquisition {

// A descriptor and the inode that it had, because descriptor numbers are reused.
struct Connection {
  int descriptor = -1;
  unsigned long long inode = 0;
  bool operator==(const Connection&) const = default;
};

// Returns the connections of this process to this address ("192.168.1.9") and TCP port.
std::vector<Connection> ConnectionsTo(const std::string& host, int port);

// Runs a function in a thread with its own copy of the descriptor table (unshare(2)), so that what it closes
// stays open in this process. Returns false, without running it, if the system does not allow that.
bool RunWithOwnDescriptors(const std::function<void()>& function);

class PtpipDescriptors {
 public:
  // Make it before the camera is opened. `port`: "ptpip:ADDRESS:PORT:PORT"; others are ignored.
  explicit PtpipDescriptors(const std::string& port);
  // Call it when the camera is open: finds the connections that the library has made.
  void Opened();
  // Runs `close_camera` with its own descriptors, then closes the camera's connections.
  void Close(const std::function<void()>& close_camera);

 private:
  bool is_ptpip_ = false;
  std::string host_;
  int port_ = 0;
  std::vector<Connection> before_, connections_;
};

}  // namespace ulf::acquisition
