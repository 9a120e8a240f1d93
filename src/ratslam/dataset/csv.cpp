#include "ratslam/dataset/csv.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>

namespace ratslam {

std::vector<std::string> splitCsv(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; std::getline(stream, word, ',');) {
    while (!word.empty() && (word.back() == '\r' || word.back() == ' ')) word.pop_back();
    words.push_back(word);
  }
  return words;
}

bool parseNumber(const std::string& text, double& number) {
  char* end = nullptr;
  number = std::strtod(text.c_str(), &end);
  while (*end == ' ' || *end == '\r' || *end == '\t') ++end;
  return end != text.c_str() && *end == '\0' && std::isfinite(number);
}

std::vector<std::string> listImages(const std::string& folder) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(folder)) throw std::runtime_error(folder + ": no such folder of images");
  std::vector<std::string> images;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".png" || ending == ".jpg" || ending == ".jpeg") images.push_back(entry.path().string());
  }
  std::sort(images.begin(), images.end());
  if (images.empty()) throw std::runtime_error(folder + ": has no .png or .jpg images");
  return images;
}

}  // namespace ratslam
