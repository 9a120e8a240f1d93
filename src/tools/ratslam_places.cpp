/// ratslam_places: writes the recalls of the local view frame by frame, for scripts/evaluate_places.
#include <algorithm>
#include <boost/program_options.hpp>
#include <filesystem>
#include <iostream>
#include <limits>
#include <stdexcept>

#include "configuration.h"
#include "image_pass.h"
#include "option_style.h"
#include "output_paths.h"
#include "ratslam/common/atomic_file.h"
#include "ratslam/common/paths.h"
#include "ratslam/local_view/local_view_cells.h"

namespace {

using namespace ratslam;
namespace po = boost::program_options;

const char kUsage[] =
    "Usage: ratslam_places REF QUERY --out FILE   learn one pass, ask with another of the same route\n"
    "       ratslam_places STREAM --min-gap N --out FILE   ask with each frame for those at least N before\n"
    "       ratslam_places STREAM [STREAM] --open --out FILE   map, and write what the system recalls\n"
    "A pass is a folder of images (in the order of their names), a KITTI sequence folder or a bag. Each "
    "image\n"
    "counts as one step on.\n";

struct Options {
  std::vector<std::string> passes;
  std::string config;
  std::string out;
  std::vector<std::string> assignments;
  std::size_t min_gap = 0;  ///< 0: not asked for
  std::size_t starts = 0;   ///< 0: not asked for
  bool open = false;
};

/// The value of an option that counts something; 0 if it is not given. @throws std::invalid_argument unless positive
std::size_t countOf(const po::variables_map& values, const std::string& option) {
  if (values.count(option) == 0) return 0;
  const auto count = values[option].as<long long>();
  if (count < 1) throwBadValue("--" + option, count, "it must be 1 or above");
  return static_cast<std::size_t>(count);
}

/// @throws std::invalid_argument naming options that are missing, or would have no effect
void requireMeaning(const Options& options) {
  const std::size_t passes = options.passes.size();
  if (options.out.empty() || passes == 0 || passes > 2 ||
      (passes == 1 && !options.open && options.min_gap == 0)) {
    throw std::invalid_argument(
        "one pass with --min-gap or --open, or two, and --out are needed; see --help");
  }
  if (options.min_gap > 0 && (passes == 2 || options.open)) {
    throw std::invalid_argument("--min-gap: it has no effect with two passes or --open");
  }
  if (options.starts > 0 && (passes == 1 || options.open)) {
    throw std::invalid_argument("--starts: it needs a second pass, and has no effect with --open");
  }
}

std::optional<Options> parse(int argc, char** argv) {
  Options options;
  po::options_description visible("Options");
  const auto add = [&visible](const char* name, const po::value_semantic* value, const char* meaning) {
    visible.add_options()(name, value, meaning);
  };
  add("out", po::value(&options.out), "CSV file to write");
  add("config", po::value(&options.config), "YAML file, or an OpenRatSLAM .txt configuration: crop and view");
  add("set", po::value(&options.assignments)->composing(), "key=value, overrides the configuration");
  add("min-gap", po::value<long long>(), "one recording: frames that a revisit lies apart at least");
  add("starts", po::value<long long>(),
      "forget the place before each of so many frames of QUERY, spread evenly, and go on from there");
  add("open", po::bool_switch(&options.open), "map and recall as the system does");
  visible.add_options()("help,h", "this text");
  po::options_description all;
  all.add(visible).add_options()("pass", po::value(&options.passes));
  po::positional_options_description positional;
  positional.add("pass", -1);
  po::variables_map values;
  po::store(po::command_line_parser(argc, argv).options(all).positional(positional).style(kOptionStyle).run(),
            values);
  po::notify(values);
  if (values.count("help") != 0) {
    std::cout << kUsage << visible;
    return std::nullopt;
  }
  options.min_gap = countOf(values, "min-gap");
  options.starts = countOf(values, "starts");
  requireMeaning(options);
  return options;
}

struct Parameters {
  ImageStageParams images;
  LocalViewParams view;
};

Parameters parametersOf(const Options& options) {
  Parameters params;
  const ParameterMap map = readConfiguration("ratslam_places", options.config, options.assignments);
  map.read(params.images);
  map.read(params.view);
  return params;
}

/// Learned places with recall.
class Places {
 public:
  explicit Places(const LocalViewParams& params)
      : params_(params), pair_(DescriptorRegistry::builtIn().make(params)) {}

  /// Begins another session on the same map: the adaptation of the descriptor is forgotten.
  void startSession() {
    pair_.descriptor = DescriptorRegistry::builtIn().make(params_).descriptor;
    wakeUp();
  }
  void wakeUp() {
    belief_.wakeUp();
    before_ = View{};
  }
  /// Describes an image. One that is left out, frozen or without texture has no view.
  std::optional<View> describe(const ImagePass::Step& step) {
    if (!step.usable()) return std::nullopt;
    return pair_.descriptor->describe(step.frame->image);
  }

  /// Learns the view of frame `frame` as a place. Without a view there is no such place.
  void learn(std::size_t frame, const std::optional<View>& view) {
    moveOn(view);
    if (!view) return;
    belief_.arrive(pair_.matcher->add(*view));
    frames_.push_back(frame);
  }

  struct Answer {
    std::int64_t place = -1;  ///< number of the frame at which it was learned
    double score = -std::numeric_limits<double>::infinity();
    bool claimed = false;
  };

  /// Recalls the place of a view among those learned before frame `end`.
  Answer ask(const std::optional<View>& view, std::size_t end) {
    const auto places =
        static_cast<std::size_t>(std::lower_bound(frames_.begin(), frames_.end(), end) - frames_.begin());
    if (places == 0 || !view || !view->textured) return {};
    pair_.matcher->compareAll(*view, likeness_);
    if (params_.recall.believes()) {
      const auto claim = belief_.weigh(likeness_, places);
      if (!claim) return {};
      return {frameOf(claim->place), claim->confidence, claim->confidence > PlaceBelief::kClaim};
    }
    std::uint32_t nearest = 0;
    double score = -std::numeric_limits<double>::infinity();
    for (std::size_t v = 0; v < likeness_.variants; ++v) {
      const float* row = likeness_.row(v);
      const float* best = std::max_element(row, row + places);
      if (static_cast<double>(*best) <= score) continue;
      nearest = static_cast<std::uint32_t>(best - row);
      score = static_cast<double>(*best);
    }
    return {frameOf(nearest), score, pair_.matcher->compareWith(*view, nearest).same_place};
  }

  /// Moves the robot on by one step, to a view if there is one, without learning it.
  void moveOn(const std::optional<View>& view) {
    const bool compared = view && !before_.variants.empty();
    belief_.move(ViewMotion::oneStep(), compared ? pair_.matcher->novelty(*view, before_) : 1.0);
    if (view) before_ = *view;
  }

 private:
  std::int64_t frameOf(std::uint32_t place) const { return static_cast<std::int64_t>(frames_[place]); }

  LocalViewParams params_;
  ViewPair pair_;
  PlaceBelief belief_;
  View before_;
  ViewLikeness likeness_;
  std::vector<std::size_t> frames_;  ///< at which each place was learned
};

void write(std::ostream& out, std::size_t frame, const Places::Answer& answer) {
  out << frame << ',' << answer.place << ',' << answer.score << ',' << (answer.claimed ? 1 : 0) << '\n';
}

void askSecondPass(const Options& options, const Parameters& params, std::ostream& out) {
  Places places(params.view);
  ImagePass learned(options.passes[0], params.images);
  std::size_t learned_frames = 0;
  while (const auto step = learned.next()) places.learn(learned_frames++, places.describe(*step));
  places.startSession();
  std::vector<std::optional<View>> views;
  ImagePass asked(options.passes[1], params.images);
  std::size_t asked_frames = 0;
  while (const auto step = asked.next()) {
    const std::size_t frame = asked_frames++;
    const auto view = places.describe(*step);
    if (options.starts > 0) {
      views.push_back(view);
      continue;
    }
    places.moveOn(view);
    write(out, frame, places.ask(view, learned_frames));
  }
  if (options.starts > views.size() && !views.empty()) {
    throw std::runtime_error("--starts: value " + std::to_string(options.starts) +
                             " is not allowed: " + options.passes[1] + " has " +
                             std::to_string(views.size()) + " images to start at");
  }
  for (std::size_t start = 0; start < options.starts; ++start) {
    const std::size_t first = start * views.size() / options.starts;
    places.wakeUp();
    for (std::size_t frame = first; frame < views.size(); ++frame) {
      places.moveOn(views[frame]);
      const Places::Answer answer = places.ask(views[frame], learned_frames);
      if (!answer.claimed) continue;
      out << first << ',';
      write(out, frame, answer);
      break;
    }
  }
}

void askOneRecording(const Options& options, const Parameters& params, std::ostream& out) {
  Places places(params.view);
  ImagePass images(options.passes[0], params.images);
  std::size_t frames = 0;
  while (const auto step = images.next()) {
    const std::size_t frame = frames++;
    const auto view = places.describe(*step);
    places.learn(frame, view);  // moves on
    write(out, frame, places.ask(view, frame >= options.min_gap ? frame - options.min_gap + 1 : 0));
  }
  if (frames <= options.min_gap) {
    throw std::runtime_error(options.passes[0] + ": it has " + std::to_string(frames) +
                             " images, so none lies --min-gap " + std::to_string(options.min_gap) +
                             " behind another");
  }
}

void mapAndRecall(const Options& options, const Parameters& params, std::ostream& out) {
  LocalViewCells cells(params.view);
  std::vector<std::size_t> learned_at;
  std::vector<std::size_t> left_at;  // last frame of the stay at which each view was learned
  bool at_newest = false;
  std::size_t frame = 0;
  for (const std::string& pass : options.passes) {
    ImagePass images(pass, params.images);
    cells.acceptAnotherSize();
    while (const auto step = images.next()) {
      const std::size_t now = frame++;
      if (step->frame && step->frame->begins_anew) cells.acceptAnotherSize();
      std::optional<ViewEvent> event;
      if (step->usable()) event = cells.observe(static_cast<Stamp>(now), step->frame->image);
      if (!event || !event->seen()) {
        out << now << ",-1,-1,0,-1\n";
        continue;
      }
      if (event->learned) {
        learned_at.push_back(now);
        left_at.push_back(now);
      }
      at_newest = event->learned || (at_newest && event->id + 1 == learned_at.size());
      if (at_newest) left_at.back() = now;
      out << now << ',' << learned_at[event->id] << ',' << event->error << ',' << (event->learned ? 0 : 1)
          << ',' << left_at[event->id] << '\n';
    }
  }
}

void run(const Options& options) {
  const Parameters params = parametersOf(options);
  requireApart({{"--config", options.config}}, {{"--out", options.out}});
  for (const std::string& pass : options.passes) {
    if (sameFile(pass, options.out) || sameFile(pass, std::filesystem::absolute(options.out).parent_path()))
      throwBadValue("--out", options.out, "it must lie in another folder than the recording's own");
  }
  AtomicFile file(options.out);
  std::ostream& out = file.stream();
  out << (options.starts > 0 ? "start," : "") << "frame,place,score,claimed"
      << (options.open ? ",until\n" : "\n");
  if (options.open) {
    mapAndRecall(options, params, out);
  } else if (options.passes.size() == 2) {
    askSecondPass(options, params, out);
  } else {
    askOneRecording(options, params, out);
  }
  file.commit();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const auto options = parse(argc, argv);
    if (options) run(*options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ratslam_places: " << error.what() << '\n';
    return 1;
  }
}
