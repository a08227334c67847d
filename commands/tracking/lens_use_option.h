// The option `--intrinsics` of the commands that track.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "tracking/tracker/tracker_options.h"

namespace ulf::commands {

inline void AddLensUseOption(CLI::App& command, tracking::LensUse& use) {
  const std::map<std::string, tracking::LensUse> words{{"fixed", tracking::LensUse::kFixed},
                                                       {"check", tracking::LensUse::kCheck},
                                                       {"refine", tracking::LensUse::kRefine}};
  command
      .add_option(
          "--intrinsics", use,
          "The lens while tracking: fixed (as given), check (as given; said where images contradict it), "
          "refine (where they do, the tracker goes on with the lens that fits and corrects the poses; "
          "where no lens is known it starts from a guess) (check)")
      ->transform(CLI::Transformer(words))
      ->check(
          CLI::IsMember({tracking::LensUse::kFixed, tracking::LensUse::kCheck, tracking::LensUse::kRefine}))
      ->type_name("fixed|check|refine");
}

}  // namespace ulf::commands
