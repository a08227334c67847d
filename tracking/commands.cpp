#include "tracking/commands.h"

#include "tracking/refine/refine_command.h"
#include "tracking/track_command.h"

namespace ulf {

void AddTrackingCommands(CLI::App& app, ChosenCommand& chosen) {
  AddTrackCommand(app, chosen);
  AddRefineCommand(app, chosen);
}

}  // namespace ulf
