// A camera that does what a test tells it, shared by the drivers that open it one after the other, as a real
// one is. It can be unplugged and put back, switched off (its clock begins anew), swapped for another one.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>

#include "acquisition/device/device.h"
#include "acquisition/device/reconnecting_device.h"
#include "tests/support/floors.h"

namespace ulf::test {

// Held by shared_ptr: drivers may be closed after the test. Everything may be called from any thread.
class ScriptedCamera : public std::enable_shared_from_this<ScriptedCamera> {
 public:
  static std::shared_ptr<ScriptedCamera> Make() { return std::make_shared<ScriptedCamera>(); }

  void Unplug();
  // The camera answers again after `boot`; `switched_off`: its clock and frame ids begin anew.
  void PlugIn(std::chrono::milliseconds boot = {}, bool switched_off = false);
  void SetSerial(const std::string& serial);
  void SetMakerAndModel(const std::string& maker, const std::string& model);
  void SetSize(cv::Size size);
  // Drivers find out so long after the camera has gone.
  void SetNoticingTakes(std::chrono::milliseconds time);
  // Opening waits so long whether the camera is there or not, as a network's time-outs do.
  void SetOpeningTakes(std::chrono::milliseconds time);
  // Closing a driver of a camera that is gone waits so long.
  void SetClosingTakes(std::chrono::milliseconds time);
  int Openings() const;  // how often opening was tried
  int Open() const;      // how many drivers exist now

  // Throws Error when the camera does not answer. Drivers keep the camera alive.
  std::unique_ptr<Device> OpenDriver();

 private:
  friend class ScriptedDriver;
  using Clock = std::chrono::steady_clock;
  bool Answers() const;

  mutable std::mutex mutex_;
  bool plugged_ = true;
  Clock::time_point answers_from_ = Clock::now();
  Clock::time_point clock_zero_ = Clock::now();
  std::string maker_ = "test", model_ = "scripted", serial_ = "S1";
  cv::Size size_{64, 48};
  std::chrono::milliseconds opening_{0}, closing_{0}, noticing_{0};
  std::uint64_t next_id_ = 1;
  int openings_ = 0, open_ = 0;
};

}  // namespace ulf::test
