#include <CLI/CLI.hpp>
#include <memory>

#include "commands/commands.h"
#include "core/base/counted.h"
#include "core/light_field/exchange/import_light_field.h"

namespace ulf::commands {
namespace {

struct ImportArgs {
  std::string source;
  std::string dir;
  std::string subject;
};

int RunImport(const ImportArgs& args) {
  ImportOptions options;
  if (!args.subject.empty()) options.subject = ParseSubject(args.subject);
  const LightField imported = Import(args.source, args.dir, options);
  const Subject& subject = *imported.subject;
  fmt::print("{}: {}, {}, subject at {:.3f} {:.3f} {:.3f} with radius {:.3f} ({} units)\n", args.dir,
             Counted(imported.views.size(), "view"), Counted(imported.cameras.size(), "camera"),
             subject.center_in_world.x(), subject.center_in_world.y(), subject.center_in_world.z(),
             subject.radius, imported.units);
  return kOk;
}

}  // namespace

void AddImportCommand(CLI::App& app, ChosenCommand& chosen) {
  auto args = std::make_shared<ImportArgs>();
  CLI::App* command =
      app.add_subcommand("import", "Take in a set by nerfstudio or instant-ngp (transforms.json)");
  command->add_option("SOURCE", args->source, "Folder with transforms.json, or the file itself")->required();
  command->add_option("-o,--output", args->dir, "New folder for the light field")->required();
  command->add_option("--subject", args->subject,
                      "Subject: x,y,z,radius in world units (default: from the optical axes)");
  command->footer("Example: ulf import fox -o fox_light_field");
  command->callback([args, &chosen] { chosen = [args] { return RunImport(*args); }; });
}

}  // namespace ulf::commands
