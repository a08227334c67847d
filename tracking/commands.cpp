#include "tracking/commands.h"

#include "tracking/track_command.h"

namespace ulf {

void AddTrackingCommands(CLI::App& app, ChosenCommand& chosen) { AddTrackCommand(app, chosen); }

}  // namespace ulf
