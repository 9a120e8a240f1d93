// ratslam_map: describes, checks, exports, prunes and merges map files.
#include <boost/program_options.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <optional>
#include <tuple>

#include "map_export.h"
#include "option_style.h"
#include "ratslam/common/atomic_file.h"
#include "ratslam/common/paths.h"
#include "ratslam/dataset/csv.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/system/map_fit.h"
#include "ratslam/system/map_merge.h"
#include "ratslam/system/map_store.h"

namespace {

using namespace ratslam;
namespace po = boost::program_options;

const char kUsage[] =
    "Usage: ratslam_map info FILE          what is in a map file (docs/map_file.md)\n"
    "       ratslam_map check FILE         whether it is sound; exits with 1 where it is not\n"
    "       ratslam_map merge A B -o OUT   one map of two, joined where they share places; the same in both "
    "orders\n"
    "       ratslam_map prune FILE -o OUT  the same map without what only the run that made it needs\n"
    "       ratslam_map export FILE --format tum|yaml|graphml|geojson -o OUT [--anchor=LAT,LON,BEARING]\n"
    "FILE is what ratslam_run --save-map wrote, or a checkpoint of a node.\n";

struct Options {
  std::string command;
  std::string file;
  std::string second;
  std::string out;
  std::string format;
  std::string anchor;
};

std::optional<Options> parse(int argc, char** argv) {
  Options options;
  std::vector<std::string> more;
  po::options_description visible("Options");
  visible.add_options()("help,h", "this text")("out,o", po::value(&options.out), "file to write")(
      "format", po::value(&options.format), "of an export")(
      "anchor", po::value(&options.anchor),
      "geojson: LAT,LON,BEARING: latitude and longitude [deg] of the map's origin, and the bearing of its x "
      "axis, "
      "clockwise from north [deg]; --anchor=-33.9,151.2,90 where it begins with a minus");
  po::options_description all;
  all.add(visible).add_options()("command", po::value(&options.command))("file", po::value(&options.file))(
      "second", po::value(&options.second))("more", po::value(&more));
  po::positional_options_description positional;
  positional.add("command", 1).add("file", 1).add("second", 1).add("more", -1);
  po::variables_map values;
  po::store(po::command_line_parser(argc, argv).options(all).positional(positional).style(kOptionStyle).run(),
            values);
  po::notify(values);
  if (values.count("help") != 0) {
    std::cout << kUsage << visible;
    return std::nullopt;
  }
  if (options.command.empty() || options.file.empty()) {
    throw std::invalid_argument("a command and a map file are needed; see --help");
  }
  if (options.second.empty() == (options.command == "merge")) {
    throw std::invalid_argument(options.command == "merge"
                                    ? "merge needs two map files"
                                    : options.second + ": " + options.command + " takes one map file");
  }
  if (!more.empty()) {
    throw std::invalid_argument(more.front() +
                                ": merge takes two map files; merge their result with the next one");
  }
  const bool writes = options.command == "merge" || options.command == "prune" || options.command == "export";
  for (const auto& [name, given, used] :
       {std::tuple{"--out", !options.out.empty(), writes},
        {"--format", !options.format.empty(), options.command == "export"},
        {"--anchor", !options.anchor.empty(), options.format == "geojson"}}) {
    if (given && !used) throw std::invalid_argument(std::string(name) + " has no effect here; see --help");
  }
  return options;
}

void info(const Options& options) {
  const MapCheckpoint map = loadMapFile(options.file);
  std::cout << options.file << ": " << std::filesystem::file_size(options.file) << " bytes, checkpoint at "
            << map.stamp << " ns, " << map.parameters.size() << " parameters\n";
  for (const MapSession& session : map.sessions) {
    std::cout << "session: version " << session.version << ", from " << session.first_stamp << " to "
              << session.last_stamp << " ns\n";
  }
  for (const MapCount& count : countMap(map)) std::cout << count.name << ": " << count.number << '\n';
}

int check(const Options& options) {
  const std::vector<std::string> faults = faultsOf(loadMapFile(options.file));
  for (const std::string& fault : faults) std::cout << options.file << ": " << fault << '\n';
  if (faults.empty()) std::cout << options.file << ": sound\n";
  return faults.empty() ? 0 : 1;
}

void requireOut(const Options& options) {
  if (options.out.empty()) throw std::invalid_argument(options.command + " needs -o FILE");
  if (sameFile(options.out, options.file) || sameFile(options.out, options.second))
    throw std::invalid_argument(options.out + ": it is the map itself");
}

void prune(const Options& options) {
  requireOut(options);
  MapCheckpoint map = loadMapFile(options.file);
  MapCheckpoint pruned = map;
  pruned.state = State();
  // Without its log a run cannot be continued. The odometry, which may hold images, then begins anew.
  const bool of_run = map.state.hasChild("run");
  for (const auto& [name, part] : map.state.children()) {
    if (name != "run" && !(of_run && name == "odometry")) pruned.state.child(name) = part;
  }
  const MapLock lock(options.out);
  MapWriter(options.out).save(pruned);
}

void merge(const Options& options) {
  requireOut(options);
  const MapCheckpoint first = loadMapFile(options.file);
  const MapCheckpoint second = loadMapFile(options.second);
  if (sameFile(options.file, options.second) || first.state == second.state)
    throw std::invalid_argument(options.second + ": it is the same map as " + options.file);
  requireAllParts(options.file, first.state);
  requireAllParts(options.second, second.state);
  // Nodes save the parameters of map and views, the runner also those of the odometry.
  std::map<std::string, std::string> parameters = first.parameters;
  parameters.insert(second.parameters.begin(), second.parameters.end());
  requireParameters(options.second, second, parameters);
  const MapMerge merged = mergeMaps(first, second);
  const MapLock lock(options.out);
  MapWriter(options.out).save(merged.map);
  std::cout << options.out << ": the map that began first has " << merged.first_experiences
            << " experiences, the other " << merged.second_experiences << ", both together "
            << merged.experiences << " in " << merged.components
            << (merged.components == 1 ? " component\n" : " components\n");
}

MapAnchor parseAnchor(const std::string& text) {
  std::vector<double> numbers;
  const std::vector<std::string> words = splitCsv(text);
  for (const std::string& word : words) {
    if (double number = 0.0; parseNumber(word, number)) numbers.push_back(number);
  }
  // Nearer to a pole the plane of a map is no patch of longitudes and latitudes.
  if (words.size() != 3 || numbers.size() != 3 || !(std::abs(numbers[0]) <= 85.0) ||
      !(std::abs(numbers[1]) <= 180.0) || !(std::abs(numbers[2]) <= 360.0)) {
    throw std::invalid_argument(
        "--anchor '" + text +
        "': it must be LAT,LON,BEARING in degrees: a latitude of -85 to 85, a longitude of -180 to "
        "180, and a bearing of -360 to 360");
  }
  return {numbers[0], numbers[1], numbers[2]};
}

/// Writes the first stretch to `first`, and each later one, whose stamps begin anew, to a file of its own.
void exportStretches(std::ostream& first, const std::string& path,
                     const std::vector<std::vector<StampedPose3>>& stretches) {
  writeTum(first, stretches.front());
  for (std::size_t number = 1; number < stretches.size(); ++number) {
    const std::string name = stretchName(path, number);
    writeTum(name, stretches[number]);
    std::cout << name << ": stretch " << number + 1 << " of " << stretches.size()
              << ", whose stamps go back behind those before\n";
  }
  // Another file of such a name may be anybody's, even the map that is exported.
  for (std::size_t number = stretches.size(); std::filesystem::exists(stretchName(path, number)); ++number) {
    std::cout << stretchName(path, number) << ": lies there already and is no stretch of this map\n";
  }
}

void exportMap(const Options& options) {
  requireOut(options);
  if (options.format.empty())
    throw std::invalid_argument("export needs --format: tum, yaml, graphml or geojson");
  AtomicFile out(options.out);
  const MapCheckpoint map = loadMapFile(options.file);
  if (map.state.find("experience_map/map/graph") == nullptr)
    throw std::runtime_error(options.file + ": it holds no experience map");
  if (options.format == "tum") {
    exportStretches(out.stream(), options.out, stretchesIn(map));
  } else if (options.format == "yaml") {
    exportYaml(out.stream(), map);
  } else if (options.format == "graphml") {
    exportGraphml(out.stream(), map);
  } else if (options.format == "geojson") {
    exportGeojson(out.stream(), map, parseAnchor(options.anchor));
  } else {
    throw std::invalid_argument("--format " + options.format + ": it must be tum, yaml, graphml or geojson");
  }
  out.close();
  out.commit();
}

int run(const Options& options) {
  if (options.command == "check") return check(options);
  if (options.command == "info") {
    info(options);
  } else if (options.command == "merge") {
    merge(options);
  } else if (options.command == "prune") {
    prune(options);
  } else if (options.command == "export") {
    exportMap(options);
  } else {
    throw std::invalid_argument(options.command + ": there is no such command; see --help");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto options = parse(argc, argv);
    return options ? run(*options) : 0;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_map: " << error.what() << '\n';
    return 1;
  }
}
