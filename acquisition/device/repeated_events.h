// Turns a device's events into lines for people: the first of a kind at once, repetitions collected into
// one line with the sum of silences, their number and the first's local time: "no frame for 6 s (12 times
// since 10:03)".
//
// Stalls count as repetitions whatever their numbers, notices, which may name files, only with the same text.
// The return of frames is said after a first stall alone. Losses and returns of the camera (kFaulted,
// kReconnecting, kRestored) are each reported.
#pragma once

#include <string>
#include <vector>

#include "acquisition/device/device.h"

namespace ulf::acquisition {

class RepeatedEvents {
 public:
  // Repetitions are collected for `every_s`, and for twice as long after each line, up to `longest_s`; after
  // `forget_s` without a repetition an event counts as new. All guessed.
  struct Options {
    double every_s = 30, longest_s = 300, forget_s = 600;
  };
  RepeatedEvents() = default;
  explicit RepeatedEvents(const Options& options) : options_(options) {}

  // Returns the lines to say now about new events and earlier ones. `now_s`: seconds since the epoch.
  std::vector<std::string> Update(const std::vector<DeviceEvent>& events, double now_s);
  // Returns the lines about events that were collected and not yet reported.
  std::vector<std::string> Finish();

 private:
  struct Repeated {
    std::string pattern;  // the text; of a stall without its numbers
    std::string text;     // of the last one
    double first_s = 0, last_s = 0;
    double silence_s = 0;  // of all, whose frames have come again
    double open_s = 0;     // of the last one, so far
    int count = 1, said = 1;
    double said_s = 0, wait_s = 0;
  };
  std::string Line(const Repeated& repeated) const;
  void Note(const DeviceEvent& event, std::vector<std::string>& lines);

  Options options_;
  std::vector<Repeated> known_;
};

}  // namespace ulf::acquisition
