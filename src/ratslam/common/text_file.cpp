#include "ratslam/common/text_file.h"

#include <locale.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <stdexcept>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = 1 << 16;
constexpr std::size_t kLargest = 1 << 30;  // a day of odometry at 200 Hz
const char kBlanks[] = " \t\v\f\r\n";

bool startsWith(const std::string& text, const std::string& beginning) {
  return text.compare(0, beginning.size(), beginning) == 0;
}

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
  throw std::runtime_error(path + ": cannot open this file: " + reason);
}

std::string readBytes(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) refuse(path, "no such file");
  if (error) refuse(path, error.message());
  if (status.type() == fs::file_type::directory) refuse(path, "it is a folder");
  if (status.type() != fs::file_type::regular) refuse(path, "it is no regular file (a pipe or a device)");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) refuse(path, std::strerror(errno));
  std::string content;
  std::vector<char> piece(kPiece);
  for (std::size_t size = 0; (size = std::fread(piece.data(), 1, kPiece, file.get())) > 0;) {
    content.append(piece.data(), size);
    // Each piece is checked, because a file that is no text may be very long.
    if (startsWith(content, "\xFF\xFE") || startsWith(content, "\xFE\xFF")) {
      refuse(path, "it is UTF-16 text; save it as UTF-8");
    }
    if (std::memchr(piece.data(), '\0', size) != nullptr) refuse(path, "it is no text");
    if (content.size() > kLargest) refuse(path, "it has more than " + std::to_string(kLargest) + " bytes");
  }
  if (std::ferror(file.get()) != 0) {
    refuse(path, std::string("it cannot be read to its end: ") + std::strerror(errno));
  }
  return content;
}

}  // namespace

std::string readText(const std::string& path) {
  const std::string bytes = readBytes(path);
  std::string text;
  text.reserve(bytes.size());
  for (std::size_t i = startsWith(bytes, "\xEF\xBB\xBF") ? 3 : 0; i < bytes.size(); ++i) {
    const bool ends_line_twice = bytes[i] == '\r' && i + 1 < bytes.size() && bytes[i + 1] == '\n';
    if (!ends_line_twice) text += bytes[i] == '\r' ? '\n' : bytes[i];
  }
  return text;
}

std::vector<TextLine> readLines(const std::string& path) {
  std::istringstream text(readText(path));
  std::vector<TextLine> lines;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::string words = trimmed(line);
    if (!words.empty()) lines.push_back({number, std::move(words)});
  }
  return lines;
}

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

double toNumber(const char* text, char** end) {
  static const locale_t kClassic = newlocale(LC_ALL_MASK, "C", nullptr);
  return strtod_l(text, end, kClassic);
}

std::string shown(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  std::string line = trimmed(text).substr(0, kLongest);
  for (char& letter : line) {
    const auto code = static_cast<unsigned char>(letter);
    if (code < 0x20 || code >= 0x7F) letter = '?';
  }
  return text.size() > kLongest ? line + "..." : line;
}

}  // namespace ratslam
