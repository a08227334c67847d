#include "commands/about/about_commands.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "core/base/error.h"
#include "render/gl/gl_context.h"

namespace ulf::commands {

void AddAboutCommands(CLI::App& app, ChosenCommand& chosen) {
  auto folder = std::make_shared<std::string>();
  CLI::App* manual = app.add_subcommand("manual", "Write the man pages into a folder");
  manual->group("");
  manual->add_option("DIR", *folder, "Folder that is there")->required()->check(CLI::ExistingDirectory);
  manual->callback([&app, &chosen, folder] {
    chosen = [&app, folder] {
      WriteManual(CommandTree(app), ULF_VERSION, *folder);
      return kOk;
    };
  });

  auto shell = std::make_shared<std::string>();
  CLI::App* completion =
      app.add_subcommand("completion", "Print the completion of a shell: bash, zsh or fish");
  completion->add_option("SHELL", *shell)->required();
  completion->callback([&app, &chosen, shell] {
    chosen = [&app, shell] {
      fmt::print("{}", CompletionScript(CommandTree(app), *shell));
      return kOk;
    };
  });
}

namespace {

std::string OpenGlText() {
  try {
    const render::GlContext context;
    return context.device();
  } catch (const Error& error) {
    return fmt::format("none: {}", error.what());
  }
}

}  // namespace

std::string VersionText(bool asks_opengl) {
  const std::string text = fmt::format("ulf {}\nbuilt with: {}", ULF_VERSION, ULF_LIBRARIES);
  return asks_opengl ? text + "\nOpenGL: " + OpenGlText() : text;
}

}  // namespace ulf::commands
