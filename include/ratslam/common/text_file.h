/// Text files as they come from everywhere: a byte order mark, ends of lines of any system and blanks around a
/// line are no part of its text. Every reader of text begins here.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

struct TextLine {
  int number = 0;  ///< from 1
  std::string text;
};

/// Content of a regular file, lines parted by '\n'.
/// @throws std::runtime_error naming the file: missing, a folder or pipe (which would never end), UTF-16, or no
/// text at all
std::string readText(const std::string& path);

/// The lines of readText that are not blank, without blanks at their ends.
std::vector<TextLine> readLines(const std::string& path);

/// Without blanks at its ends.
std::string trimmed(const std::string& text);

/// A piece of a file's text as a message may show it: one line, not too long, nothing unprintable.
std::string shown(const std::string& text);

}  // namespace ratslam
