#include "ratslam/dataset/image_folder.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <stdexcept>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

bool isDigit(char letter) { return letter >= '0' && letter <= '9'; }

std::string inSmallLetters(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return text;
}

/// The letters up to the next digit. Advances `at` past them.
std::string wordAt(const std::string& text, std::size_t& at) {
  const std::size_t begin = at;
  while (at < text.size() && !isDigit(text[at])) ++at;
  return text.substr(begin, at - begin);
}

/// The number that begins at `at`, without leading zeros. Advances `at` past it.
std::string numberAt(const std::string& text, std::size_t& at) {
  std::size_t end = at;
  while (end < text.size() && isDigit(text[end])) ++end;
  std::string number = text.substr(at, end - at);
  number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
  at = end;
  return number;
}

/// The numbers at the ends of the names; empty unless they are ascending and the names are equal before them.
std::vector<std::size_t> numbersOf(const std::vector<std::string>& images) {
  constexpr std::size_t kMostDigits = 18;
  std::vector<std::size_t> numbers;
  std::optional<std::string> before;
  for (const std::string& path : images) {
    const std::string name = fs::path(path).stem().string();
    std::size_t digits = name.size();
    while (digits > 0 && isDigit(name[digits - 1])) --digits;
    if (digits == name.size() || name.size() - digits > kMostDigits) return {};
    if (before && *before != name.substr(0, digits)) return {};
    before = name.substr(0, digits);
    numbers.push_back(std::stoull(name.substr(digits)));
    if (numbers.size() > 1 && numbers.back() <= numbers[numbers.size() - 2]) return {};
  }
  return numbers;
}

}  // namespace

bool naturallyBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (true) {
    const std::string word = wordAt(a, i);
    const std::string other_word = wordAt(b, j);
    if (word != other_word) return word < other_word;
    if (i == a.size() || j == b.size()) break;
    const std::string number = numberAt(a, i);
    const std::string other_number = numberAt(b, j);
    if (number.size() != other_number.size()) return number.size() < other_number.size();
    if (number != other_number) return number < other_number;
  }
  const bool a_ends = i == a.size();
  const bool b_ends = j == b.size();
  return a_ends && b_ends ? a < b : a_ends;  // orders names that differ only in leading zeros
}

std::vector<std::string> imagesIn(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> images;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = inSmallLetters(entry.path().extension().string());
    const bool hidden = entry.path().filename().string().front() == '.';
    std::error_code dangling;  // a dangling link counts as an image, which then cannot be read
    if (!hidden && (ending == ".png" || ending == ".jpg" || ending == ".jpeg") &&
        !entry.is_directory(dangling)) {
      images.push_back(entry.path().string());
    }
  }
  if (error) throw std::runtime_error(folder + ": cannot be read: " + error.message());
  std::sort(images.begin(), images.end(), naturallyBefore);
  return images;
}

std::vector<std::string> listImages(const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw std::runtime_error(folder + ": no such folder of images");
  std::vector<std::string> images = imagesIn(folder);
  if (images.empty()) throw std::runtime_error(folder + ": has no .png or .jpg images");
  return images;
}

std::vector<std::size_t> timesOf(const std::vector<std::string>& images, std::size_t count,
                                 const std::string& times_path) {
  std::vector<std::size_t> rows(images.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  if (count == images.size()) return rows;
  const std::string complaint =
      times_path + ": " + std::to_string(count) + " times for " + std::to_string(images.size()) + " images";
  if (count < images.size()) throw std::runtime_error(complaint);
  const std::vector<std::size_t> numbers = numbersOf(images);
  if (numbers.empty()) {
    throw std::runtime_error(complaint + ", whose names do not tell which of them is missing");
  }
  const std::size_t first = numbers.front();
  const std::size_t last = numbers.back();
  std::size_t base = 0;
  if (last == count && first >= 1) {
    base = 1;
  } else if (last >= count) {
    if (last - first + 1 != count) {
      throw std::runtime_error(complaint + " numbered " + std::to_string(first) + " to " +
                               std::to_string(last) + ": which time is whose is not clear");
    }
    base = first;
  }
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = numbers[i] - base;
  return rows;
}

}  // namespace ratslam
