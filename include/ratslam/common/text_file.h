/// Reading of text files from any system. Byte order mark, line endings and blanks around a line are removed. All
/// readers of text use it.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

struct TextLine {
  int number = 0;  ///< from 1
  std::string text;
};

/// Content of a regular file, with '\n' between lines.
/// @throws std::runtime_error naming the file: missing, a folder or pipe (which would never end), UTF-16, or no
/// text at all
std::string readText(const std::string& path);

/// The lines of readText that are not blank, without blanks at their ends.
std::vector<TextLine> readLines(const std::string& path);

/// The text without blanks at its ends.
std::string trimmed(const std::string& text);

bool endsWith(const std::string& text, const std::string& ending);

/// The number at the beginning of a text, as std::strtod reads it in the "C" locale, whatever the program's locale is.
/// @param end  becomes the end of the number, or the text's beginning if there is none
double toNumber(const char* text, char** end);

/// Part of a file's text for a message: one line, not too long, printable characters only.
std::string shown(const std::string& text);

}  // namespace ratslam
