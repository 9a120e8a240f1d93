// What another project writes to use the core: one step of the pose cells, and the camera of a recording.
#include <iostream>

#include "ratslam/dataset/registry.h"
#include "ratslam/pose_cells/network.h"

int main(int argc, char** argv) {
  ratslam::PoseCellNetwork network{ratslam::PoseCellParams{}};
  network.step(0.5, 0.1);
  for (int i = 1; i < argc; ++i) {
    const auto recording = ratslam::folderRecordings().open(argv[i], {});
    std::cout << recording->imageCount() << " images\n";
  }
  return network.reseeds() == 0 ? 0 : 1;
}
