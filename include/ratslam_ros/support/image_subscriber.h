/// Images from a topic, raw or compressed, through the image stage. All nodes with images subscribe by it.
///
/// An image that cannot be used never ends a node: it is counted, reported and left out. So are images that are dropped
/// because they come faster than they are processed. Diagnostics show the counts once a second.
#pragma once

#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <array>
#include <functional>
#include <string>

#include "ratslam/system/image_stage.h"
#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/drop_oldest_queue.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/stream_watch.h"

namespace ratslam {

/// The topic of a transport for the images of `base`. As in image_transport, a remapping of the base topic holds for all
/// of its transports.
std::string transportTopic(const ros::NodeHandle& handle, const std::string& base,
                           const std::string& transport);

/// Processing speed of a stream of images.
struct ImageTraffic {
  std::size_t dropped = 0;  ///< number of images dropped because the processing was too slow
  double delay_s = 0.0;     ///< from arrival to the end of processing, for the last image
  double age_s = 0.0;       ///< from stamp to arrival, for the last image; contains the difference of clocks
};

class ImageSubscriber {
 public:
  /// Receives a frame and the header of its message. If it throws, the reason is reported and the image left out.
  using Handler = std::function<void(const std_msgs::Header&, const ImageFrame&)>;

  /// @param topic  base topic; /compressed is appended for that transport
  ImageSubscriber(const ros::NodeHandle& handle, const NodeParams& params, const ImageStageParams& images,
                  const std::string& topic, Handler handler);

  void start();
  const std::string& topic() { return watch_.topic(); }
  /// To be called a few times a second.
  void watchStream() {
    watch_.warnIfItNeverCame();
    dropped_.remind();
  }

  /// Until release() the images wait, still encoded. `on_arrival` receives each of them.
  void hold(std::function<void(const RecordedImage&)> on_arrival) {
    on_arrival_ = std::move(on_arrival);
    queue_.hold();
  }
  void release() {
    on_arrival_ = nullptr;
    queue_.release();
  }
  bool somethingWaits() const { return queue_.waiting() > 0; }

  /// State against which later images are checked.
  void save(State& state) const { stage_.save(state); }
  void load(const State& state) { stage_.load(state); }

  const ImageTraffic& traffic() const { return traffic_; }
  const ImageCounts& counts() const { return stage_.counts(); }

 private:
  struct Waiting {
    std_msgs::Header header;
    RecordedImage image;
    ros::WallTime arrived;
    ros::Time arrived_ros;
  };

  template <class Message>
  void subscribe();
  void push(const Waiting& waiting);
  void process(const Waiting& waiting);

  ros::NodeHandle handle_;
  bool compressed_;
  bool stamps_by_arrival_;
  std::string topic_;
  ImageLimits limits_;
  Handler handler_;
  std::function<void(const RecordedImage&)> on_arrival_;  ///< while images are held
  std::array<CountedWarning, kImageEvents> warnings_;
  ImageStage stage_;
  StreamWatch watch_;
  DropOldestQueue<Waiting> queue_;
  ImageTraffic traffic_;
  CountedWarning dropped_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
