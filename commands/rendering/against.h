// Runs `ulf evaluate A --against B`: two light fields of the same photographs, refined, posed or chosen
// otherwise, render the same left-out photographs, each from its own other views by its own poses.
#pragma once

#include <string>
#include <vector>

#include "commands/options/scene_options.h"
#include "commands/rendering/protocol_evaluation.h"
#include "render/fields/field_options.h"

namespace ulf::commands {

// Leaves out what `args.protocol` says of the photographs that both have, and pixels that either masks.
// Prints scores side by side, or as one JSON object if `json`; writes them to the CSV file `table` unless
// that is empty, and pictures to A/ and B/ in `args.out`. Throws Error if no photograph is in both, and as
// EvaluateSplit() does. A subject and an up direction of `scene_args` are in A's world.
int RunAgainst(const ProtocolArgs& args, const SceneArgs& scene_args,
               const std::vector<render::FieldOptions>& fields, const std::string& table, bool json);

}  // namespace ulf::commands
