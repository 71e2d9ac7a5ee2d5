// One name, one type: two types of one name in different files of a program are undefined, and neither
// compiler nor linker says so.
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/places.h"

#include "tests/support/files.h"

using namespace hdrcam;
using test::text_of;

namespace {

namespace fs = std::filesystem;

bool of_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// C++ as its words and signs; comments, literals and what is the preprocessor's are left out.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  // The next one; empty at the end.
  std::string_view next() {
    while (at_ < text_.size()) {
      const std::size_t begin = at_;
      const char c = text_[at_];
      if (text_.substr(at_, 2) == "//")
        skip_line();
      else if (text_.substr(at_, 2) == "/*")
        skip_behind("*/");
      else if (c == '#' && fresh_line_)
        skip_line();
      else if (c == '"' || c == '\'')
        skip_literal(c);
      else if (of_word(c)) {
        while (at_ < text_.size() && (of_word(text_[at_]) || is_digit_separator())) ++at_;
        fresh_line_ = false;
        const std::string_view word = text_.substr(begin, at_ - begin);
        if (!word.ends_with('R') || text_.substr(at_, 1) != "\"") return word;
        const std::size_t open = std::min(text_.find('(', at_), text_.size());
        skip_behind(")" + std::string(text_.substr(at_ + 1, open - at_ - 1)) + "\"");
      } else {
        fresh_line_ = c == '\n' || (fresh_line_ && std::isspace(static_cast<unsigned char>(c)) != 0);
        at_ += text_.substr(at_, 2) == "::" ? 2 : 1;
        if (std::isspace(static_cast<unsigned char>(c)) == 0) return text_.substr(begin, at_ - begin);
      }
    }
    return {};
  }

 private:
  bool is_digit_separator() const {
    return text_[at_] == '\'' && at_ + 1 < text_.size() && of_word(text_[at_ + 1]);
  }
  void skip_behind(std::string_view end) {
    const std::size_t found = text_.find(end, at_ + 1);
    at_ = found == std::string_view::npos ? text_.size() : found + end.size();
  }
  // With those that a backslash joins to it.
  void skip_line() {
    for (; at_ < text_.size() && text_[at_] != '\n'; ++at_)
      if (text_[at_] == '\\') ++at_;
  }
  void skip_literal(char quote) {
    for (++at_; at_ < text_.size() && text_[at_] != quote; ++at_)
      if (text_[at_] == '\\') ++at_;
    ++at_;
    fresh_line_ = false;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  bool fresh_line_ = true;  // nothing but blanks before, on the line
};

// The name of the type that a brace behind these words begins to define; empty where it begins something
// else.
std::string defined_type(const std::vector<std::string>& before) {
  std::vector<std::string> words;  // without attributes and bases
  int brackets = 0;
  for (const std::string& word : before) {
    if (word == ":") break;
    brackets += (word == "[") - (word == "]");
    if (brackets == 0 && word != "]") words.push_back(word);
  }
  if (!words.empty() && words.back() == "final") words.pop_back();
  constexpr std::array<std::string_view, 4> kKinds{"struct", "class", "union", "enum"};
  if (words.size() < 2 || std::find(kKinds.begin(), kKinds.end(), words[words.size() - 2]) == kKinds.end())
    return {};
  return of_word(words.back()[0]) ? words.back() : std::string();
}

// The types that a text defines in no other type and no function, with their namespaces; those in a namespace
// without a name are the file's own.
std::set<std::string> shared_types(std::string_view text) {
  std::set<std::string> types;
  struct Scope {
    std::string name;  // of a namespace, with "::" behind it
    bool is_shared;
  };
  std::vector<Scope> scopes{{"", true}};
  std::vector<std::string> before;  // since the last statement
  Words words(text);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "{") {
      Scope inner{scopes.back().name, false};
      const auto space = std::find(before.begin(), before.end(), "namespace");
      if (space != before.end()) {
        for (auto part = space + 1; part != before.end(); ++part) inner.name += *part;
        inner.name += "::";
        inner.is_shared = scopes.back().is_shared && space + 1 != before.end();
      } else if (const std::string type = defined_type(before); !type.empty() && scopes.back().is_shared)
        types.insert(scopes.back().name + type);
      scopes.push_back(std::move(inner));
    } else if (word == "}" && scopes.size() > 1)
      scopes.pop_back();
    if (word == "{" || word == "}" || word == ";")
      before.clear();
    else
      before.emplace_back(word);
  }
  return types;
}

using FilesOfTypes = std::map<std::string, std::vector<std::string>>;

void note_types(const std::string& path, std::string_view text, FilesOfTypes& files) {
  for (const std::string& type : shared_types(text)) files[type].push_back(path);
}

// One sentence per name that several files give to a type.
std::vector<std::string> names_given_twice(const FilesOfTypes& files) {
  std::vector<std::string> found;
  for (const auto& [type, paths] : files) {
    if (paths.size() < 2) continue;
    std::string sentence = type + " is defined in";
    for (const std::string& path : paths) sentence += " " + path;
    found.push_back(sentence + ": rename one, or put those of a single file into a namespace without a name");
  }
  return found;
}

const fs::path kRoot = HDRCAM_SOURCE_DIR;

}  // namespace

TEST_CASE("no two files define a type of the same name") {
  FilesOfTypes files;
  for (const char* folder : {"hal", "capture", "online", "render", "firmware_host", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".h" || extension == ".cpp")
        note_types(fs::relative(entry.path(), kRoot).generic_string(), text_of(entry.path()), files);
    }
  CHECK(files.contains("hdrcam::FrameFacts"));
  CHECK(files.contains("hdrcam::Result"));
  for (const std::string& sentence : names_given_twice(files)) FAIL_CHECK(sentence);
}

TEST_CASE("the check of types finds a name that two files give, however they write it") {
  const std::vector<std::string> spellings{
      "namespace hdrcam {\nstruct Row {\n  int y;\n};\n}",
      "namespace hdrcam {\nnamespace {\nint zero() { return 0; }\n}  // namespace\nclass Row final : public "
      "A<B> {};\n}",
      "#define OPEN {\nnamespace hdrcam { template <class T>\nclass Row {}; }",
      "namespace hdrcam { const char* const kBrace = \"{\"; char c = '{'; int n = 1'000; /* { */ // {\n"
      "enum class Row : int { First }; }",
      "namespace hdrcam { struct [[nodiscard]] Row {}; }",
      "namespace hdrcam { const char* const kText = R\"(})\"; union Row {}; }"};
  for (const std::string& text : spellings) {
    INFO(text);
    FilesOfTypes files;
    note_types("online/a.h", "namespace hdrcam { struct Row {}; }", files);
    CHECK(names_given_twice(files).empty());
    note_types("online/b.cpp", text, files);
    CHECK(names_given_twice(files) ==
          std::vector<std::string>{"hdrcam::Row is defined in online/a.h online/b.cpp: rename one, or put "
                                   "those of a single file into a namespace without a name"});
  }
}

TEST_CASE("the check of types lets a file have its own, and a name stand in two scopes") {
  const std::vector<std::string> own{"namespace hdrcam {\nnamespace {\nstruct Row {};\n}\n}",
                                     "namespace hdrcam::test { struct Row {}; }",
                                     "namespace hdrcam { class Table { struct Row {}; }; }",
                                     "namespace hdrcam { void f() { struct Row {}; } }",
                                     "namespace hdrcam { struct Row; Row row_of(const struct Row& row) {} }",
                                     "namespace hdrcam { struct Row* next() { return nullptr; } }",
                                     "namespace hdrcam { template <> struct Of<Row> {}; }"};
  for (const std::string& text : own) {
    INFO(text);
    CHECK_FALSE(shared_types(text).contains("hdrcam::Row"));
  }
}
