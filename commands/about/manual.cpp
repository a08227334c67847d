#include "commands/about/about_commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>

#include "core/base/atomic_file.h"

namespace ulf::commands {
namespace {

// Escapes text for roff, so that no character of it is an instruction.
std::string Roff(const std::string& text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else {
      out += c;
    }
    line_begins = c == '\n';
  }
  return out;
}

// Quotes the text so that it is one argument of .SH, .B and so on.
std::string RoffArgument(const std::string& text) {
  std::string out;
  for (const char c : Roff(text)) out += c == '"' ? std::string("\\(dq") : std::string(1, c);
  return '"' + out + '"';
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string Capitalized(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

// Returns the text without a full stop, for NAME. The program's own begins with its name, a heading already.
std::string PlainText(const CommandPage& page) {
  std::string text = page.text;
  if (page.path.empty() && text.starts_with("ulf: ")) text.erase(0, 5);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string Sentence(const std::string& text) {
  return text.empty() || text.ends_with('.') ? text : text + ".";
}

std::string Synopsis(const CommandPage& page) {
  std::string out = fmt::format(".B {}\n", RoffArgument(page.FullName(" ")));
  out += "[\\fIoptions\\fR]\n";
  for (const OptionPage& option : page.options) {
    if (!option.positional) continue;
    const std::string name =
        fmt::format("\\fI{}\\fR{}", Roff(option.names.front()), option.repeats ? " ..." : "");
    out += option.required ? name + "\n" : "[" + name + "]\n";
  }
  if (!page.commands.empty()) out += "\\fIcommand\\fR\n";
  return out;
}

std::string OptionText(const OptionPage& option) {
  std::string names;
  for (const std::string& name : option.names) {
    names += names.empty() ? "" : ", ";
    names += (option.positional ? "\\fI" : "\\fB") + Roff(name) + "\\fR";
  }
  if (!option.value.empty() && !option.positional) names += " \\fI" + Roff(option.value) + "\\fR";
  std::string out = ".TP\n" + names + "\n" + Roff(Sentence(option.text)) + "\n";
  if (!option.default_value.empty()) out += "Default: " + Roff(option.default_value) + ".\n";
  if (option.required) out += "Required.\n";
  return out;
}

std::string SeeAlso(const CommandPage& page, const CommandPage& tree) {
  std::vector<std::string> pages;
  for (const CommandPage* other : AllPages(tree)) {
    const bool is_above = other->path.size() < page.path.size() &&
                          std::equal(other->path.begin(), other->path.end(), page.path.begin());
    const bool is_below = other->path.size() == page.path.size() + 1 &&
                          std::equal(page.path.begin(), page.path.end(), other->path.begin());
    const bool is_beside = page.path.size() == 1 && other->path.size() == 1 && other != &page;
    if (is_above || is_below || is_beside) pages.push_back(other->FullName("-"));
  }
  std::string out;
  for (std::size_t i = 0; i < pages.size(); ++i)
    out += fmt::format(".BR {} (1){}\n", Roff(pages[i]), i + 1 < pages.size() ? "," : "");
  return out;
}

}  // namespace

std::string ManPage(const CommandPage& page, const CommandPage& tree, const std::string& version) {
  std::string out = fmt::format(".TH {} 1 \"\" {} {}\n", RoffArgument(Upper(page.FullName("-"))),
                                RoffArgument("ulf " + version), RoffArgument("Light fields"));
  out += fmt::format(".SH NAME\n{} \\- {}\n", Roff(page.FullName("-")), Roff(PlainText(page)));
  out += ".SH SYNOPSIS\n" + Synopsis(page);
  out += ".SH DESCRIPTION\n" + Roff(Sentence(Capitalized(PlainText(page)))) + "\n";
  if (!page.commands.empty()) {
    out += ".PP\nCommands, each with a page of its own:\n";
    for (const CommandPage& command : page.commands)
      out += fmt::format(".TP\n.B {}\n{}\n", RoffArgument(command.Name()), Roff(command.text));
  }
  out += ".SH OPTIONS\n";
  for (const OptionPage& option : page.options) out += OptionText(option);
  if (!page.footer.empty()) out += ".SH EXAMPLES\n.nf\n" + Roff(page.footer) + "\n.fi\n";
  out += fmt::format(
      ".SH EXIT STATUS\n.TP\n.B {}\nDone.\n.TP\n.B {}\nThe work failed; standard error says what and "
      "why.\n.TP\n.B {}\n"
      "Wrong usage.\n",
      kOk, kFailed, kWrongUsage);
  out +=
      ".SH FILES\nPages of docs/ that are named here are in /usr/share/doc/ulf/docs, or under the prefix "
      "that ulf\n"
      "was installed to.\n";
  out += ".SH SEE ALSO\n" + SeeAlso(page, tree);
  return out;
}

void WriteManual(const CommandPage& tree, const std::string& version, const std::filesystem::path& folder) {
  std::vector<std::string> texts;  // the batch refers to them
  const std::vector<const CommandPage*> pages = AllPages(tree);
  texts.reserve(pages.size());
  FileBatch batch;
  for (const CommandPage* page : pages) {
    texts.push_back(ManPage(*page, tree, version));
    batch.Write(folder / (page->FullName("-") + ".1"), ContentOf(texts.back()));
  }
  batch.Commit();
}

}  // namespace ulf::commands
