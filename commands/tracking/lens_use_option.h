// The option `--intrinsics` of the commands that track.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

// `refines`: the command can go on with another lens.
inline void AddLensUseOption(CLI::App& command, tracking::LensUse& use, bool refines) {
  static const std::map<std::string, tracking::LensUse> kWords{{"fixed", tracking::LensUse::kFixed},
                                                               {"check", tracking::LensUse::kCheck},
                                                               {"refine", tracking::LensUse::kRefine}};
  command
      .add_option_function<std::string>(
          "--intrinsics", [&use](const std::string& word) { use = kWords.at(word); },
          refines
              ? "The lens while tracking: fixed (as given), check (as given; said where images contradict "
                "it), "
                "refine (where they do, the tracker goes on with the lens that fits and corrects the poses; "
                "where no lens is known it starts from a guess) (check)"
              : "The lens while tracking: fixed (as given) or check (as given; said where images contradict "
                "it) "
                "(check)")
      ->check([](const std::string& word) {
        return kWords.contains(word) ? std::string() : "'" + word + "' is none of fixed, check and refine";
      })
      ->type_name(refines ? "fixed|check|refine" : "fixed|check");
}

}  // namespace ulf::commands
