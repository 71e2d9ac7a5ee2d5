#include "firmware_host/packaging/manual_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include "firmware_host/exit_code.h"
#include "firmware_host/version.h"

namespace hdrcam {
namespace {

// As roff prints it: a dash that is a minus sign, no escape, no request at the beginning of a line.
std::string roff(std::string_view text) {
  std::string out;
  if (text.starts_with('.') || text.starts_with('\'')) out = "\\&";
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\n')
      out += ' ';
    else
      out += c;
  }
  return out;
}

std::string heading(std::string_view name) {
  std::string upper(name);
  std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return std::toupper(c); });
  return fmt::format(".TH {} 1 \"{}\" \"hdrcam {}\" \"hdrcam manual\"\n", roff(upper), kReleased, kVersion);
}

std::string title(std::string_view name, std::string_view about) {
  return heading(name) + fmt::format(".SH NAME\n{} \\- {}\n", roff(name), roff(about));
}

// "-o, --output TEXT", bold and italic.
std::string tag_of(const FlagEntry& flag) {
  std::string tag;
  for (const std::string& name : flag.names)
    tag += fmt::format("{}\\fB{}\\fR", tag.empty() ? "" : ", ", roff(name));
  if (flag.kind != ValueKind::None) tag += fmt::format(" \\fI{}\\fR", roff(flag.value));
  return tag;
}

std::string paragraph(const FlagEntry& flag) {
  std::string text = fmt::format(".TP\n{}\n{}", tag_of(flag), roff(flag.about));
  if (!flag.usual.empty()) text += fmt::format("; default {}", roff(flag.usual));
  return text + '\n';
}

std::string flags_of(const std::vector<FlagEntry>& flags) {
  std::string text = ".SH OPTIONS\n";
  std::string_view group = "Options";
  for (const FlagEntry& flag : flags) {
    if (flag.group != group) text += fmt::format(".SS {}\n", roff(group = flag.group));
    text += paragraph(flag);
  }
  return text;
}

std::string exit_status() {
  std::string text = ".SH EXIT STATUS\n";
  for (const ExitCode& code : exit_codes())
    text += fmt::format(".TP\n{}\n{}\n", code.number, roff(code.meaning));
  return text;
}

std::string reference_to(std::string_view page, bool last) {
  return fmt::format(".BR {} (1){}\n", roff(page), last ? "" : ",");
}

ManualPage page_of_program(const CommandTable& table) {
  std::string text = title("hdrcam", "HDR video from a camera that alternates its exposure");
  text += ".SH SYNOPSIS\n\\fBhdrcam\\fR \\fIVERB\\fR [\\fIflags\\fR]\n";
  text += fmt::format(".SH DESCRIPTION\n{}\n", roff(table.about));
  std::string_view group;
  for (const VerbEntry& verb : table.verbs) {
    if (verb.group != group) text += fmt::format(".SS {}\n", roff(group = verb.group));
    text += fmt::format(".TP\n\\fBhdrcam {}\\fR\n{}\n", roff(verb.name), roff(verb.about));
  }
  text += flags_of(table.flags);
  text += ".SH EXAMPLES\n";
  for (const VerbEntry& verb : table.verbs)
    text += fmt::format(".TP\n{}:\n\\fB{}\\fR\n", roff(verb.about), roff(verb.example));
  text += exit_status() + ".SH SEE ALSO\n";
  for (const VerbEntry& verb : table.verbs)
    text += reference_to("hdrcam-" + verb.name, &verb == &table.verbs.back());
  return {"hdrcam.1", text};
}

ManualPage page_of(const VerbEntry& verb) {
  const std::string name = "hdrcam-" + verb.name;
  std::string text = title(name, verb.about);
  text += fmt::format(".SH SYNOPSIS\n\\fBhdrcam {}\\fR", roff(verb.name));
  std::string flags = " [\\fIflags\\fR]";
  for (const FlagEntry& argument : verb.arguments) {
    // The flags of a verb's own verb stand behind that verb.
    if (argument.names.front() != kInnerVerb) text += std::exchange(flags, "");
    text += fmt::format(" {}\\fI{}\\fR{}{}", argument.required ? "" : "[", roff(argument.names.front()),
                        argument.repeated ? " ..." : "", argument.required ? "" : "]");
  }
  text += flags;
  text += '\n';
  if (!verb.arguments.empty()) text += ".SH ARGUMENTS\n";
  for (const FlagEntry& argument : verb.arguments) text += paragraph(argument);
  text += flags_of(verb.flags);
  text += fmt::format(".SH EXAMPLES\n\\fB{}\\fR\n", roff(verb.example));
  text += exit_status() + ".SH SEE ALSO\n" + reference_to("hdrcam", true);
  return {name + ".1", text};
}

}  // namespace

std::vector<ManualPage> manual_pages(const CommandTable& table) {
  std::vector<ManualPage> pages{page_of_program(table)};
  for (const VerbEntry& verb : table.verbs) pages.push_back(page_of(verb));
  return pages;
}

}  // namespace hdrcam
