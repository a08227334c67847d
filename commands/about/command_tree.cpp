#include "commands/about/command_tree.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

namespace ulf::commands {
namespace {

std::vector<std::string> Split(const std::string& text, char separator) {
  return CLI::detail::split(text, separator);
}

// Accepts a name that is no number, as in "PX|full".
bool IsWord(const std::string& text) {
  return !text.empty() && std::islower(static_cast<unsigned char>(text.front())) &&
         std::ranges::all_of(text, [](unsigned char c) { return std::isalnum(c) || c == '-'; });
}

// "TEXT:{high,fast,FILE}" and "fixed|check|refine" name the values.
std::vector<std::string> WordsOf(const std::string& value) {
  std::vector<std::string> words;
  const std::size_t open = value.find('{'), close = value.find('}');
  if (open != std::string::npos && close != std::string::npos && close > open)
    words = Split(value.substr(open + 1, close - open - 1), ',');
  else if (value.find('|') != std::string::npos)
    words = Split(value, '|');
  std::erase_if(words, [](const std::string& word) { return !IsWord(word); });
  return words;
}

OptionPage PageOf(const CLI::Option& option) {
  OptionPage page;
  page.positional = option.get_positional();
  page.required = option.get_required();
  page.repeats = option.get_expected_max() >= CLI::detail::expected_max_vector_size;
  page.text = option.get_description();
  if (page.positional) {
    page.names = {option.get_name(true)};
  } else {
    for (const std::string& name : option.get_snames()) page.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) page.names.push_back("--" + name);
  }
  if (option.get_items_expected_max() == 0) return page;
  page.value = option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
  page.default_value = option.get_default_str();
  page.words = WordsOf(page.value);
  page.takes_file = (page.words.empty() && page.value.starts_with("TEXT")) || page.value.ends_with(",FILE}");
  return page;
}

CommandPage PageOf(const CLI::App& app, std::vector<std::string> path) {
  CommandPage page;
  page.path = std::move(path);
  page.text = app.get_description();
  page.footer = app.get_footer();
  for (const CLI::Option* option :
       app.get_options([](const CLI::Option* o) { return !o->get_group().empty(); }))
    page.options.push_back(PageOf(*option));
  for (const CLI::App* command : app.get_subcommands(
           [](const CLI::App* a) { return !a->get_group().empty() && !a->get_name().empty(); })) {
    std::vector<std::string> below = page.path;
    below.push_back(command->get_name());
    page.commands.push_back(PageOf(*command, std::move(below)));
  }
  return page;
}

}  // namespace

std::string CommandPage::FullName(const std::string& between) const {
  std::string name = "ulf";
  for (const std::string& part : path) name += between + part;
  return name;
}

CommandPage CommandTree(const CLI::App& app) { return PageOf(app, {}); }

std::vector<const CommandPage*> AllPages(const CommandPage& tree) {
  std::vector<const CommandPage*> pages{&tree};
  for (const CommandPage& command : tree.commands)
    for (const CommandPage* page : AllPages(command)) pages.push_back(page);
  return pages;
}

}  // namespace ulf::commands
