// ratslam_run: the whole system over a recording, without a roscore, as fast as the machine allows.
#include <unistd.h>

#include <boost/program_options.hpp>
#include <csignal>
#include <iostream>
#include <memory>

#include "ratslam/common/progress_bar.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/pipeline/run_log.h"
#include "ratslam_ros/node_parameters.h"
#include "recordings.h"

namespace {

namespace po = boost::program_options;
using namespace ratslam;

volatile std::sig_atomic_t interrupted = 0;

struct Options {
  std::string input;
  std::string config;
  std::string out;
  std::string odometry = "profile";
  std::vector<std::string> assignments;
  std::size_t max_frames = 0;
  RecordingOptions recording;
  int decode_threads = 2;
};

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

/// @return nullopt where the user only asked for help
std::optional<Options> parse(int argc, char** argv) {
  Options options;
  po::options_description visible("Options");
  visible.add_options()("help,h", "this text");
  visible.add_options()("list-parameters", "print all parameters as a table");
  visible.add_options()("config", po::value(&options.config),
                        "YAML file, or an OpenRatSLAM .txt configuration");
  visible.add_options()("out", po::value(&options.out), "folder for the results");
  visible.add_options()(
      "odometry", po::value(&options.odometry)->default_value("profile"),
      "profile (intensity profiles), orb (ORB features), topic (of the bag) or a CSV file with the columns "
      "frame,stamp,linear_x,angular_z");
  visible.add_options()("set", po::value(&options.assignments)->composing(),
                        "key=value, overrides the configuration");
  visible.add_options()("max-frames", po::value(&options.max_frames)->default_value(0),
                        "stop after so many images");
  visible.add_options()("image-topic", po::value(&options.recording.image_topic),
                        "bag: image topic, raw or compressed (default: the only one)");
  visible.add_options()("odometry-topic", po::value(&options.recording.odometry_topic),
                        "bag: odometry topic (default: the only one that ends with odom)");
  visible.add_options()("decode-threads", po::value(&options.decode_threads)->default_value(2),
                        "threads that decode images ahead; the results do not depend on it");
  po::options_description all;
  all.add(visible).add_options()("input", po::value(&options.input));
  po::positional_options_description positional;
  positional.add("input", 1);
  po::variables_map values;
  po::store(po::command_line_parser(argc, argv).options(all).positional(positional).run(), values);
  po::notify(values);
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
  return options;
}

ParameterMap readParameters(const Options& options) {
  ParameterMap map;
  if (!options.config.empty()) map = ParameterMap::fromFile(options.config);
  for (const std::string& assignment : options.assignments) map.setFromAssignment(assignment);
  map.rejectUnknown(systemKeys());
  return map;
}

int run(const Options& options) {
  const PipelineParams params = PipelineParams::fromMap(readParameters(options));
  RecordingOptions recording_options = options.recording;
  recording_options.with_odometry = options.odometry == "topic";
  std::unique_ptr<Recording> recording = openRecording(options.input, recording_options);
  const auto camera = params.camera.model() ? params.camera.model() : cameraOf(*recording);
  OdometrySource source;
  if (options.odometry == "profile") {
    source = profileOdometry(params);
  } else if (options.odometry == "orb") {
    if (!camera) {
      throw std::runtime_error(options.input +
                               ": --odometry orb needs a calibration: calib.txt, camera_info in the " +
                               "bag, or camera_fx ... in the configuration");
    }
    source = orbOdometry(params, *camera);
  } else if (options.odometry != "topic") {
    recording =
        std::make_unique<RecordingWithOdometry>(std::move(recording), readOdometryCsv(options.odometry));
  }
  Pipeline pipeline(params, source, camera);
  RunLog log(options.out);
  DecodeAhead items(*recording, options.decode_threads);
  std::size_t frames = 0;
  std::size_t corrupt = 0;
  const std::size_t total = options.max_frames == 0 ? recording->imageCount()
                                                    : std::min(options.max_frames, recording->imageCount());
  ProgressBar bar(std::cerr, total, "frames", isatty(STDERR_FILENO) != 0);
  while (interrupted == 0 && (options.max_frames == 0 || frames < options.max_frames)) {
    const auto item = items.next();
    if (!item) break;
    if (const auto* sample = std::get_if<OdometrySample>(&*item)) {
      log.append(pipeline.addOdometry(*sample));
      continue;
    }
    const auto& image = std::get<DecodedImage>(*item);
    ++frames;
    bar.update(frames);
    if (image.image.empty()) {
      if (++corrupt == 1) std::cerr << "ratslam_run: " << image.name << ": " << image.error << "; skipped\n";
      continue;
    }
    log.append(pipeline.addImage(image.stamp, image.image));
  }
  log.finish(pipeline, params,
             {{"frames", static_cast<double>(frames)}, {"corrupt_images", static_cast<double>(corrupt)}});
  std::cout << frames << " frames (" << corrupt << " corrupt), " << pipeline.localView().size()
            << " templates, " << pipeline.map().graph().experiences().size() << " experiences, "
            << pipeline.map().graph().links().size() << " links -> " << options.out << '\n';
  if (interrupted != 0) std::cout << "interrupted: the results hold what was mapped so far\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  try {
    const auto options = parse(argc, argv);
    return options ? run(*options) : 0;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_run: " << error.what() << '\n';
    return 1;
  }
}
