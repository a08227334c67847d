// The option `--tracking-side` of the commands that track.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "tracking/tracker/tracker.h"

namespace ulf::commands {

inline constexpr int kSmallestTrackingSide = 160, kLargestTrackingSide = 20000;  // px

inline void AddTrackingSideOption(CLI::App& command, int& side_px) {
  command
      .add_option_function<std::string>(
          "--tracking-side",
          [&side_px](const std::string& text) { side_px = text == "full" ? 0 : std::stoi(text); },
          "Longer side that larger pictures are reduced to for tracking, px, or full: tracked as they come. "
          "Poses and intrinsics are those of the pictures as they come")
      ->check([](const std::string& text) {
        int px = 0;
        const bool good = text == "full" || text == "0" ||
                          (CLI::detail::lexical_cast(text, px) && px >= kSmallestTrackingSide &&
                           px <= kLargestTrackingSide);
        return good ? std::string()
                    : "'" + text + "' is neither full nor a whole number of pixels from " +
                          std::to_string(kSmallestTrackingSide) + " to " +
                          std::to_string(kLargestTrackingSide);
      })
      ->type_name("PX|full")
      ->default_str(std::to_string(tracking::TrackerOptions{}.max_side_px));
}

}  // namespace ulf::commands
