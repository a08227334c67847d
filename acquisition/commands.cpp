#include "acquisition/commands.h"

#include "acquisition/import_command.h"

namespace ulf {

void AddAcquisitionCommands(CLI::App& app, ChosenCommand& chosen) { AddImportCommand(app, chosen); }

}  // namespace ulf
