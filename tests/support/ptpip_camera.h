// Emulates a tethered camera on loopback: a PTP/IP responder (ISO 15740 over CIPA DC-005) that libgphoto2's
// own ptp2 driver opens as `ptpip:127.0.0.1:PORT:PORT`. It runs in this process, on threads of its own; every
// function may be called at any time.
//
// The camera presents itself as a Nikon, whose live view that driver serves with few operations; pictures
// come from the test. Calls make what happens in a studio: a busy camera, a full card, a shutter released on
// the body, a property that the camera turns itself, a slow download, a link that drops.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/floors.h"

namespace ulf::test {

// Property codes of PTP that the camera has.
inline constexpr std::uint16_t kPtpBattery = 0x5001;      // percent
inline constexpr std::uint16_t kPtpImageFormat = 0x5004;  // 2: JPEG fine, 4: NEF, 5: NEF and JPEG
inline constexpr std::uint16_t kPtpFNumber = 0x5007;      // hundredths
inline constexpr std::uint16_t kPtpFocusMode = 0x500A;    // 1: manual, 0x8010: AF-S
inline constexpr std::uint16_t kPtpExposure = 0x500D;     // 0.1 ms
inline constexpr std::uint16_t kPtpProgram = 0x500E;      // 1: manual, 2: program
inline constexpr std::uint16_t kPtpIso = 0x500F;
// Of PtpipCameraOptions::brackets.
inline constexpr std::uint16_t kPtpCaptureMode = 0x5013;  // 1: single, 2: burst
inline constexpr std::uint16_t kPtpBurstNumber = 0x5018;
inline constexpr std::uint16_t kPtpBracketSet = 0xD078;   // 1: exposure only
inline constexpr std::uint16_t kPtpBracketing = 0xD0C0;   // 1: on
inline constexpr std::uint16_t kPtpBracketStep = 0xD0C1;  // 3: 1 EV, 4: 2 EV
inline constexpr std::uint16_t kPtpBracketPattern = 0xD0C2;

struct PtpipFile {
  std::string name;  // "DSC_0001.JPG"; two files of one photograph share the stem
  std::string bytes;
  std::string written = "20260101T120000";  // by the camera's clock
};

struct PtpipCameraOptions {
  bool live_view = true;
  double shutter_lag_s = 0.05;      // from the request to the shutter
  double download_bytes_per_s = 0;  // 0: as fast as it goes
  double between_files_s = 0;       // of one photograph, from announcement to announcement
  std::string serial = "3001234";
  // The camera has bracketing: one release takes as many exposures as its burst number says, while bracketing
  // is on in burst mode.
  bool brackets = false;
};

class PtpipCamera {
 public:
  using LivePicture = std::function<std::string()>;  // returns a JPEG; called for every live view frame
  // Returns a photograph's files; called when the shutter opens, with its number, which counts from 1.
  using Photograph = std::function<std::vector<PtpipFile>(int)>;

  PtpipCamera(LivePicture live, Photograph photograph, const PtpipCameraOptions& options = {});
  ~PtpipCamera();
  PtpipCamera(const PtpipCamera&) = delete;
  PtpipCamera& operator=(const PtpipCamera&) = delete;

  int Port() const { return port_; }
  std::string Uri() const;  // for OpenDevice()

  void PressShutter();  // on the body
  // The next so many requests for a release, for a file, or to turn bracketing on or off are answered "busy".
  void AnswerBusy(int requests) { busy_ = requests; }
  void AnswerDownloadsBusy(int requests) { busy_downloads_ = requests; }
  void AnswerBracketingBusy(int requests) { busy_bracketing_ = requests; }
  void SetCardFull(bool full) { card_full_ = full; }
  void FailDownloads(int downloads) { failing_downloads_ = downloads; }  // the next so many
  void FailDownloadsOfRaw(bool fail) { raw_fails_ = fail; }
  void Forget();                   // drops every file: the card is out
  void PutOnCard(PtpipFile file);  // without an event
  void AnnounceAgain();            // sends the event of every file that it holds
  // Lets the next answer to this operation (ptp_wire.h) come so much too late, as when a camera hangs or a
  // network stalls.
  void Stall(std::uint16_t operation, double seconds) {
    stall_s_ = seconds;
    stalled_operation_ = operation;
  }
  bool IsToStall() const { return stalled_operation_ != 0; }
  // Presses the shutter on the body just before the next release that is asked for.
  void PressBeforeNextRelease() { press_first_ = true; }
  void DropLink();                                            // both connections, at once
  void Refuse(bool refuse) { refuse_ = refuse; }              // new connections, as when switched off
  void SetProperty(std::uint16_t code, std::uint32_t value);  // as the camera does itself, with its event
  std::uint32_t Property(std::uint16_t code) const;

  int Releases() const { return releases_; }             // how often the shutter opened
  int ReleasesAsked() const { return releases_asked_; }  // requests that were not refused
  int BusyAnswers() const { return busy_answers_; }
  std::vector<std::string> FilesKept() const;  // by name, in order

 private:
  struct Value {
    std::uint16_t type = 0;  // 2: 8 bits, 4: 16 bits, 6: 32 bits, all unsigned
    std::uint32_t value = 0;
    std::vector<std::uint32_t> choices;  // empty: read only
    bool is_range = false;               // choices are least, most, step
  };
  struct Request;
  class Connection;

  void Accept();
  void Serve(std::shared_ptr<Connection> connection);
  void Commands(Connection& connection);
  void Answer(Connection& connection, const Request& request);
  void AnswerObject(Connection& connection, const Request& request);
  void AnswerProperty(Connection& connection, const Request& request);
  void AnswerRelease(Connection& connection, const Request& request);
  void AnswerLiveView(Connection& connection, const Request& request);
  std::string DeviceInfo() const;
  std::string PropertyDescription(std::uint16_t code) const;
  void Release(std::uint32_t transaction);  // schedules a shutter
  void Shutter();                           // the thread that opens it
  void Event(std::uint16_t code, std::uint32_t transaction, std::uint32_t parameter, int parameters = 1);

  const LivePicture live_;
  const Photograph photograph_;
  const PtpipCameraOptions options_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<int> busy_{0}, busy_downloads_{0}, busy_bracketing_{0}, releases_{0}, busy_answers_{0},
      failing_downloads_{0}, releases_asked_{0};
  std::atomic<bool> card_full_{false}, refuse_{false}, stop_{false}, press_first_{false}, raw_fails_{false};
  std::atomic<double> stall_s_{0};
  std::atomic<std::uint16_t> stalled_operation_{0};

  mutable std::mutex mutex_;
  std::condition_variable released_;
  std::vector<std::uint32_t> waiting_releases_;
  std::map<std::uint32_t, PtpipFile> objects_;
  std::uint32_t next_object_ = 1;
  std::map<std::uint16_t, Value> properties_;
  std::vector<std::shared_ptr<Connection>> connections_;
  std::shared_ptr<Connection> events_;
  std::vector<std::thread> threads_;
  std::thread accept_, shutter_;
};

}  // namespace ulf::test
