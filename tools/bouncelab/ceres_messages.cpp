// SPDX-License-Identifier: GPL-3.0-or-later
/// What Ceres says, on standard error, without glog.
///
/// glog brings gflags, libunwind and liblzma with it: four shared libraries whose loading was a seventh of the time
/// that the program takes to start, for messages that are hardly ever said. These are the members of glog's classes
/// that Ceres calls, by the names that the linker sees. Ceres makes the objects; here is used the first pointer of
/// each, and glog's have one there as well (0.4 to 0.6, which tools/bouncelab/CMakeLists.txt asks for). With these
/// definitions the linker does not need glog (--as-needed).
#include <array>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>

// NOLINTBEGIN(readability-*, bugprone-*, cppcoreguidelines-*, misc-*): names and ownership are glog's

namespace fLI {
extern int FLAGS_v, FLAGS_minloglevel;
int FLAGS_v = 0;            // most detailed messages for debugging
int FLAGS_minloglevel = 0;  // least severity that is said
}  // namespace fLI

namespace google {

struct CheckOpString {
  std::string* text;
};
struct SiteFlag {
  int* level;
};

bool InitVLOG3__(SiteFlag* site, int* level, const char*, int wanted);
bool InitVLOG3__(SiteFlag* site, int* level, const char*, int wanted) {
  site->level = level;
  return *level >= wanted;
}

class LogMessage {
 public:
  LogMessage(const char* file, int line);
  LogMessage(const char* file, int line, int severity);
  ~LogMessage();
  std::ostream& stream();

 protected:
  void say();

 private:
  struct Text {
    int severity;
    std::ostringstream said;
  };
  Text* text_;
};

LogMessage::LogMessage(const char* file, int line, int severity) : text_(new Text{severity, {}}) {
  static constexpr std::array<const char*, 4> kSeverities{"", "warning: ", "error: ", "fatal: "};
  text_->said << "bouncelab: Ceres: " << kSeverities.at(static_cast<std::size_t>(severity)) << file << ":" << line
              << ": ";
}
LogMessage::LogMessage(const char* file, int line) : LogMessage(file, line, 0) {}
LogMessage::~LogMessage() { say(); }
std::ostream& LogMessage::stream() { return text_->said; }
void LogMessage::say() {
  if (text_->severity >= fLI::FLAGS_minloglevel) std::cerr << text_->said.str() + "\n";
  delete text_;
}

class LogMessageFatal : public LogMessage {
 public:
  LogMessageFatal(const char* file, int line);
  LogMessageFatal(const char* file, int line, const CheckOpString& failed);
  [[noreturn]] ~LogMessageFatal();
};

LogMessageFatal::LogMessageFatal(const char* file, int line) : LogMessage(file, line, 3) {}
LogMessageFatal::LogMessageFatal(const char* file, int line, const CheckOpString& failed)
    : LogMessageFatal(file, line) {
  stream() << "check failed: " << *failed.text << " ";
}
LogMessageFatal::~LogMessageFatal() {
  say();
  std::abort();
}

namespace base {

/// "a == b (1 vs. 2)"
class CheckOpMessageBuilder {
 public:
  explicit CheckOpMessageBuilder(const char* expression);
  ~CheckOpMessageBuilder();
  std::ostream* ForVar2();
  std::string* NewString();

 private:
  std::ostringstream* text_;  // which glog's header has Ceres write the first value to
};

CheckOpMessageBuilder::CheckOpMessageBuilder(const char* expression) : text_(new std::ostringstream) {
  *text_ << expression << " (";
}
CheckOpMessageBuilder::~CheckOpMessageBuilder() { delete text_; }
std::ostream* CheckOpMessageBuilder::ForVar2() {
  *text_ << " vs. ";
  return text_;
}
std::string* CheckOpMessageBuilder::NewString() {
  *text_ << ")";
  return new std::string(text_->str());
}

}  // namespace base
}  // namespace google

// NOLINTEND(readability-*, bugprone-*, cppcoreguidelines-*, misc-*)
