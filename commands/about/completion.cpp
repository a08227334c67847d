#include "commands/about/about_commands.h"
#include "commands/options/command_line.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>

#include "core/base/shell_word.h"

namespace ulf::commands {
namespace {

std::string Replaced(const std::string& text, const std::vector<std::pair<char, std::string>>& replacements) {
  std::string out;
  for (const char c : text) {
    const auto found = std::ranges::find_if(replacements, [c](const auto& r) { return r.first == c; });
    out += found == replacements.end() ? std::string(1, c) : found->second;
  }
  return out;
}

// --help has whole sentences; a list of completions has room for the beginning.
std::string Short(const std::string& text) {
  constexpr std::size_t kWidth = 70;
  std::string line = text.substr(0, text.find('\n'));
  if (line.size() <= kWidth) return line;
  const std::size_t blank = line.rfind(' ', kWidth - 3);
  line.resize(blank == std::string::npos ? kWidth - 3 : blank);
  return line + "...";
}

template <typename Choose>
std::vector<std::string> NamesWhere(const CommandPage& page, Choose&& choose) {
  std::vector<std::string> names;
  for (const OptionPage& option : page.options)
    if (!option.positional && choose(option))
      names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

std::vector<std::string> CommandNames(const CommandPage& page) {
  std::vector<std::string> names;
  for (const CommandPage& command : page.commands) names.push_back(command.Name());
  return names;
}

bool TakesFiles(const CommandPage& page) {
  return std::ranges::any_of(page.options,
                             [](const OptionPage& option) { return option.positional && option.takes_file; });
}

// --- bash: one function with a case for each command, whose words are in `command`.

std::string BashPage(const CommandPage& page) {
  std::string out = fmt::format("    {})\n", ShellWord(fmt::format("{}", fmt::join(page.path, " "))));
  out += "      case $previous in\n";
  for (const OptionPage& option : page.options) {
    if (option.positional || option.words.empty()) continue;
    out += fmt::format("        {}) words={}{} ;;\n", fmt::join(option.names, "|"),
                       ShellWord(fmt::format("{}", fmt::join(option.words, " "))),
                       option.takes_file ? "; files=yes" : "");
  }
  const auto files =
      NamesWhere(page, [](const OptionPage& option) { return option.words.empty() && option.takes_file; });
  if (!files.empty()) out += fmt::format("        {}) files=yes ;;\n", fmt::join(files, "|"));
  const auto others = NamesWhere(page, [](const OptionPage& option) {
    return !option.value.empty() && option.words.empty() && !option.takes_file;
  });
  if (!others.empty()) out += fmt::format("        {}) return ;;\n", fmt::join(others, "|"));
  const auto all = NamesWhere(page, [](const OptionPage&) { return true; });
  out += fmt::format("        *) words={}; options={}; files={} ;;\n      esac ;;\n",
                     ShellWord(fmt::format("{}", fmt::join(CommandNames(page), " "))),
                     ShellWord(fmt::format("{}", fmt::join(all, " "))), TakesFiles(page) ? "yes" : "");
  return out;
}

std::string Bash(const CommandPage& tree) {
  std::string out =
      "# bash completion for ulf, made by `ulf completion bash`.\n_ulf() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]}\n"
      "  local command= words= options= files= i\n  COMPREPLY=()\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    case \"$command ${COMP_WORDS[i]}\" in\n";
  for (const CommandPage* page : AllPages(tree)) {
    if (page->path.empty()) continue;
    const std::vector<std::string> above(page->path.begin(), page->path.end() - 1);
    out += fmt::format("      {}) command={} ;;\n",
                       ShellWord(fmt::format("{} {}", fmt::join(above, " "), page->Name())),
                       ShellWord(fmt::format("{}", fmt::join(page->path, " "))));
  }
  out += "    esac\n  done\n  case $command in\n";
  for (const CommandPage* page : AllPages(tree)) out += BashPage(*page);
  out +=
      "  esac\n"
      "  [[ $current != -* ]] || words=$options files=\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
      "  if [[ $files ]]; then\n"
      "    compopt -o filenames 2>/dev/null\n"
      "    local IFS=$'\\n'\n"
      "    COMPREPLY+=($(compgen -f -- \"$current\"))\n"
      "  fi\n}\ncomplete -F _ulf ulf\n";
  return out;
}

// --- zsh: a function for each command describes its options to _arguments.

std::string ZshFunction(const CommandPage& page) { return page.FullName("_").insert(0, "_"); }

std::string ZshText(const std::string& text) {
  return Replaced(Short(text), {{'[', "("}, {']', ")"}, {':', "\\:"}, {'\\', "\\\\"}});
}

std::string ZshOption(const OptionPage& option) {
  std::string value;
  if (!option.words.empty() && option.takes_file)
    value = fmt::format(":value:{{compadd -- {}; _files}}", fmt::join(option.words, " "));
  else if (!option.words.empty())
    value = fmt::format(":value:({})", fmt::join(option.words, " "));
  else if (option.takes_file)
    value = ":value:_files";
  else if (!option.value.empty())
    value = ":value: ";
  if (option.positional) return ShellWord(fmt::format("{}{}", option.repeats ? "*" : "", value));
  const std::string text = fmt::format("[{}]{}", ZshText(option.text), value);
  if (option.names.size() == 1) return option.names.front() + ShellWord(text);
  return ShellWord(fmt::format("({})", fmt::join(option.names, " "))) +
         fmt::format("{{{}}}", fmt::join(option.names, ",")) + ShellWord(text);
}

std::string ZshPage(const CommandPage& page) {
  std::string out =
      ZshFunction(page) + "() {\n  local context state state_descr line\n  typeset -A opt_args\n";
  if (!page.commands.empty()) {
    out += "  local -a commands\n  commands=(\n";
    for (const CommandPage& command : page.commands)
      out += "    " + ShellWord(command.Name() + ":" + Short(command.text)) + "\n";
    out += "  )\n";
  }
  out += "  _arguments -C";
  for (const OptionPage& option : page.options) out += " \\\n    " + ZshOption(option);
  if (page.commands.empty()) return out + "\n}\n";
  out += " \\\n    '1: :->command' \\\n    '*:: :->rest'\n  case $state in\n";
  out += "    command) _describe command commands ;;\n    rest)\n      case $words[1] in\n";
  for (const CommandPage& command : page.commands)
    out += fmt::format("        {}) {} ;;\n", command.Name(), ZshFunction(command));
  return out + "      esac ;;\n  esac\n}\n";
}

std::string Zsh(const CommandPage& tree) {
  std::string out = "#compdef ulf\n# zsh completion for ulf, made by `ulf completion zsh`.\n";
  for (const CommandPage* page : AllPages(tree)) out += ZshPage(*page);
  // Loaded by name on the first use, this file is the function; if sourced, it only registers with zsh.
  return out + "if [[ $funcstack[1] == _ulf ]]; then _ulf \"$@\"; else compdef _ulf ulf; fi\n";
}

// --- fish: a line for each option has the condition that its command was typed.

std::string FishQuoted(const std::string& text) {
  return "'" + Replaced(text, {{'\'', "\\'"}, {'\\', "\\\\"}, {'\n', " "}}) + "'";
}

std::string FishCondition(const CommandPage& page) {
  if (page.path.empty()) return "__fish_use_subcommand";
  std::string out;
  for (const std::string& part : page.path)
    out += fmt::format("{}__fish_seen_subcommand_from {}", out.empty() ? "" : "; and ", part);
  if (!page.commands.empty())
    out += fmt::format("; and not __fish_seen_subcommand_from {}", fmt::join(CommandNames(page), " "));
  return out;
}

std::string FishPage(const CommandPage& page) {
  const std::string line = fmt::format("complete -c ulf -n {}", FishQuoted(FishCondition(page)));
  std::string out;
  for (const CommandPage& command : page.commands)
    out += fmt::format("{} -f -a {} -d {}\n", line, command.Name(), FishQuoted(Short(command.text)));
  if (page.commands.empty() && !TakesFiles(page)) out += line + " -f\n";
  for (const OptionPage& option : page.options) {
    if (option.positional) {
      if (!option.words.empty())
        out +=
            fmt::format("{} -f -a {}\n", line, FishQuoted(fmt::format("{}", fmt::join(option.words, " "))));
      continue;
    }
    out += line;
    for (const std::string& name : option.names)
      out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.words.empty())
      out += fmt::format(" {} -a {}", option.takes_file ? "-r -F" : "-x",
                         FishQuoted(fmt::format("{}", fmt::join(option.words, " "))));
    else if (option.takes_file)
      out += " -r -F";
    else if (!option.value.empty())
      out += " -x";
    out += fmt::format(" -d {}\n", FishQuoted(Short(option.text)));
  }
  return out;
}

std::string Fish(const CommandPage& tree) {
  std::string out = "# fish completion for ulf, made by `ulf completion fish`.\n";
  for (const CommandPage* page : AllPages(tree)) out += FishPage(*page);
  return out;
}

}  // namespace

std::string CompletionScript(const CommandPage& tree, const std::string& shell) {
  if (shell == "bash") return Bash(tree);
  if (shell == "zsh") return Zsh(tree);
  if (shell == "fish") return Fish(tree);
  throw UsageError("completion '{}': there is none for this shell; there are bash, zsh and fish", shell);
}

}  // namespace ulf::commands
