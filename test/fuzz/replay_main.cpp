// Runs every target over its corpus and over all that was ever found: fuzz_replay CORPUS
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include "target.h"

namespace fs = std::filesystem;
using namespace ratslam::fuzz;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_replay CORPUS\n";
    return 2;
  }
  std::vector<Target> targets = fileTargets();
  for (const auto& more : {stageTargets(), messageTargets()})
    targets.insert(targets.end(), more.begin(), more.end());
  std::size_t replayed = 0;
  for (const Target& target : targets) {
    const fs::path folder = fs::path(argv[1]) / target.name;
    if (!fs::is_directory(folder)) {
      std::cerr << folder.string() << ": the target has no corpus\n";
      return 1;
    }
    std::vector<fs::path> inputs(fs::directory_iterator(folder), fs::directory_iterator{});
    std::sort(inputs.begin(), inputs.end());
    replayed += inputs.size();
    for (const fs::path& path : inputs) {
      std::cout << target.name << ' ' << path.filename().string() << std::endl;  // seen also where it crashes
      std::ifstream file(path, std::ios::binary);
      const std::vector<char> content{std::istreambuf_iterator<char>(file), {}};
      const auto begin = std::chrono::steady_clock::now();
      target.run(Bytes(content.begin(), content.end()));
      require(std::chrono::steady_clock::now() - begin < std::chrono::seconds(25), "an input takes no 25 s");
    }
  }
  std::cout << "replayed " << replayed << " inputs\n";
  return 0;
}
