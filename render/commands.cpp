#include "render/commands.h"

#include "render/evaluate_command.h"
#include "render/render_command.h"
#include "render/stereo/proxy_command.h"
#include "render/viewer/view_command.h"

namespace ulf {

void AddRenderCommands(CLI::App& app, ChosenCommand& chosen) {
  AddRenderCommand(app, chosen);
  AddEvaluateCommand(app, chosen);
  AddProxyCommand(app, chosen);
  AddViewCommand(app, chosen);
}

}  // namespace ulf
