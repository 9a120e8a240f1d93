#include "run_options.h"

#include <boost/program_options.hpp>
#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "option_style.h"
#include "output_paths.h"
#include "ratslam/common/paths.h"
#include "ratslam/odometry/registry.h"
#include "ratslam/system/run_log.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;

constexpr int kMostDecodeThreads = 64;

const char kUsage[] =
    "Usage: ratslam_run INPUT --config FILE --out DIR [options]\n"
    "INPUT is a bag, a KITTI sequence folder (image_0/, times.txt, calib.txt) or an Android recorder's "
    "folder.\n"
    "Example: ratslam_run kitti/sequences/00 --config config/kitti.yaml --out out/00 --set exp_loops=10\n";

/// Prints the table of docs/parameters.md.
void listParameters() {
  std::cout << "| key | default | meaning |\n|---|---|---|\n";
  PipelineParams().visitFields(
      [](const std::string& key, const auto& value, const Bounds&, const char* meaning) {
        std::cout << "| `" << key << "` | ";
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, bool>) {
          std::cout << (value ? "true" : "false");
        } else if constexpr (std::is_same_v<Value, std::vector<double>>) {
          std::cout << "[]";
        } else {
          std::cout << value;
        }
        std::cout << " | " << meaning << " |\n";
      });
}

po::options_description describe(RunOptions& options) {
  po::options_description visible("Options");
  std::string odometries;  // the description copies it
  const OdometryRegistry registry = standardOdometry();
  for (const OdometryKind& kind : registry.kinds()) {
    odometries += (odometries.empty() ? "" : "; ") + kind.name + ": " + kind.meaning;
  }
  const auto add = [&visible](const char* name, const po::value_semantic* value, const char* meaning) {
    visible.add_options()(name, value, meaning);
  };
  visible.add_options()("help,h", "this text")("list-parameters", "print all parameters as a table");
  add("config", po::value(&options.config), "YAML file, or an OpenRatSLAM .txt configuration");
  add("out", po::value(&options.out), "folder for the results");
  add("odometry", po::value(&options.odometry)->default_value("profile"), odometries.c_str());
  add("calibration", po::value(&options.calibration),
      "YAML file of the camera's intrinsics, as config/calibration/phone_example.yaml (a recorder's folder "
      "has none of its own)");
  add("rotate", po::value(&options.recording.rotate_deg)->default_value(0),
      "recorder's folder: turn the images clockwise by 90, 180 or 270 degrees; the calibration is of turned "
      "ones");
  add("set", po::value(&options.assignments)->composing(), "key=value, overrides the configuration");
  add("changes", po::value(&options.changes),
      "file of parameters that change in the middle, as ratslam_em writes it: lines of after_ns,name,value");
  add("max-frames", po::value<long long>()->default_value(0), "stop after so many images");
  add("from-frame", po::value<long long>()->default_value(0),
      "begin with this image, counted from 0, and the odometry behind the one before it");
  add("save-map", po::value(&options.save_map), "write the map to this file at the end (docs/map_file.md)");
  add("load-map", po::value(&options.load_map),
      "go on in the map of this file: where the saved run ended, if the first image follows its last within "
      "time_reset, else on a new stretch");
  visible.add_options()("localise-only", po::bool_switch(&options.localise_only),
                        "learn nothing: only find places of the map of --load-map");
  add("video", po::value(&options.video),
      ".mp4 or .avi file to show the run in: views and templates, pose cells, map; at camera_hz");
  add("pose-cells-at", po::value(&options.pose_cells_at),
      "times [s] at which to keep the pose cells' activity for pictures, such as 10,20.5 (default: six "
      "moments spread evenly)");
  add("image-folder", po::value(&options.recording.image_folder),
      "KITTI sequence: folder of its images, such as image_2 (with P2 of calib.txt), or . for the sequence's "
      "own "
      "(default: image_0)");
  add("pose-cells-every", po::value<long long>()->default_value(0),
      "keep the pose cells' activity after every so many views in pose_cells.npz: arrays stamps [ns] and "
      "activity "
      "(snapshots, headings, rows, columns), for numpy.load (0: not at all)");
  add("image-topic", po::value(&options.recording.image_topic),
      "bag: image topic, raw or compressed (default: the only one)");
  add("odometry-topic", po::value(&options.recording.odometry_topic),
      "bag: odometry topic (default: the only one that ends with odom)");
  add("decode-threads", po::value(&options.decode_threads)->default_value(2),
      "threads that decode images ahead; the results do not depend on it");
  return visible;
}

}  // namespace

std::optional<RunOptions> parseRunOptions(int argc, char** argv) {
  RunOptions options;
  const po::options_description visible = describe(options);
  po::options_description all;
  all.add(visible).add_options()("input", po::value(&options.input));
  po::positional_options_description positional;
  positional.add("input", 1);
  po::variables_map values;
  try {
    po::store(
        po::command_line_parser(argc, argv).options(all).positional(positional).style(kOptionStyle).run(),
        values);
    po::notify(values);
  } catch (const po::invalid_option_value& error) {  // all options other than strings are integers
    throw std::invalid_argument(std::string(error.what()) + ": it must be a whole number");
  } catch (const po::too_many_positional_options_error&) {
    throw std::invalid_argument("one INPUT at a time; a path with blanks stands in quotes; see --help");
  } catch (const po::error& error) {
    throw std::invalid_argument(std::string(error.what()) + "; see --help");
  }
  if (values.count("help") != 0) {
    std::cout << kUsage << visible;
    return std::nullopt;
  }
  if (values.count("list-parameters") != 0) {
    listParameters();
    return std::nullopt;
  }
  if (options.input.empty() || options.out.empty())
    throw std::invalid_argument("INPUT and --out are needed; see --help");
  const auto most = values["max-frames"].as<long long>();
  if (most < 0) throwBadValue("--max-frames", most, "it must be 0 (all) or above");
  options.max_frames = static_cast<std::size_t>(most);
  const auto from = values["from-frame"].as<long long>();
  if (from < 0) throwBadValue("--from-frame", from, "it must be 0 or above");
  options.from_frame = static_cast<std::size_t>(from);
  const auto every = values["pose-cells-every"].as<long long>();
  if (every < 0) throwBadValue("--pose-cells-every", every, "it must be 0 (not at all) or above");
  options.pose_cells_every = static_cast<std::size_t>(every);
  for (const auto& [name, value] : values) {
    const auto* text = boost::any_cast<std::string>(&value.value());
    if (text != nullptr && text->empty() && name != "odometry") {
      throw std::invalid_argument("--" + name + ": it is given, but empty");
    }
  }
  for (std::string* path :
       {&options.input, &options.out, &options.config, &options.odometry, &options.calibration,
        &options.changes, &options.save_map, &options.load_map, &options.video}) {
    *path = withHome(*path);
  }
  if (options.localise_only && (options.load_map.empty() || !options.save_map.empty())) {
    throw std::invalid_argument("--localise-only needs --load-map and has nothing for --save-map");
  }
  if (options.decode_threads < 1 || options.decode_threads > kMostDecodeThreads) {
    throwBadValue("--decode-threads", options.decode_threads,
                  "it must lie within [1, " + std::to_string(kMostDecodeThreads) + "]");
  }
  return options;
}

void requireOutputsApart(const RunOptions& options) {
  if (sameFile(options.input, options.out)) {
    throwBadValue("--out", options.out, "it must be another folder than the recording's own");
  }
  const std::vector<OptionPath> read = {{"INPUT", options.input},
                                        {"--config", options.config},
                                        {"--odometry", options.odometry},
                                        {"--calibration", options.calibration},
                                        {"--changes", options.changes}};
  const OptionPath loaded = {"--load-map", options.load_map};
  const OptionPath saved = {"--save-map", options.save_map};
  const OptionPath video = {"--video", options.video};
  requireApart(read, {saved, video});  // a map may be saved where it was loaded
  requireApart({loaded}, {video});
  for (const OptionPath& file : {read[1], read[2], read[3], read[4], loaded, saved, video}) {
    std::error_code error;  // what is missing is no conflict
    const fs::path path = fs::weakly_canonical(fs::absolute(file.path, error), error);
    const bool part = path.extension() == ".part";
    if (!file.path.empty() && sameFile(path.parent_path(), options.out) &&
        RunLog::writes((part ? path.stem() : path.filename()).string())) {
      throwBadValue("--out", options.out, "its own files would take the place of " + file.path);
    }
  }
}

}  // namespace ratslam
