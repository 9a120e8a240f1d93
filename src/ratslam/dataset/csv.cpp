#include "ratslam/dataset/csv.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "ratslam/common/text_file.h"

namespace ratslam {

namespace {

/// Removes the quotes with which spreadsheets write words.
std::string unquoted(const std::string& word) {
  const bool quoted = word.size() >= 2 && word.front() == '"' && word.back() == '"';
  return quoted ? trimmed(word.substr(1, word.size() - 2)) : word;
}

}  // namespace

std::vector<std::string> splitCsv(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; std::getline(stream, word, ',');) words.push_back(unquoted(trimmed(word)));
  return words;
}

bool parseNumber(const std::string& text, double& number) {
  const std::string word = trimmed(text);
  if (word.empty() || word.find_first_not_of("0123456789+-.eE") != std::string::npos) return false;
  char* end = nullptr;
  number = toNumber(word.c_str(), &end);
  return *end == '\0' && std::isfinite(number);
}

}  // namespace ratslam
