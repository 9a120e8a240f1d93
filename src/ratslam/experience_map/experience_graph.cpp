#include "ratslam/experience_map/experience_graph.h"

#include <stdexcept>
#include <string>

namespace ratslam {

std::uint32_t ExperienceGraph::addExperience(const MapPose& pose) {
  Experience experience;
  experience.pose = pose;
  experiences_.push_back(experience);
  ++revision_;
  return static_cast<std::uint32_t>(experiences_.size() - 1);
}

std::uint32_t ExperienceGraph::addLink(Link link) {
  if (link.from >= experiences_.size() || link.to >= experiences_.size() || link.from == link.to) {
    throw std::invalid_argument("link from experience " + std::to_string(link.from) + " to " +
                                std::to_string(link.to) + ": it must join two of the " +
                                std::to_string(experiences_.size()) + " experiences");
  }
  const auto id = static_cast<std::uint32_t>(links_.size());
  link.next_outgoing = link.next_incoming = kNoLink;
  links_.push_back(link);
  Experience& from = experiences_[link.from];
  Experience& to = experiences_[link.to];
  (from.last_outgoing == kNoLink ? from.first_outgoing : links_[from.last_outgoing].next_outgoing) = id;
  (to.last_incoming == kNoLink ? to.first_incoming : links_[to.last_incoming].next_incoming) = id;
  from.last_outgoing = id;
  to.last_incoming = id;
  ++revision_;
  return id;
}

bool ExperienceGraph::linked(std::uint32_t a, std::uint32_t b) const {
  return linkStarts(a, b) || linkStarts(b, a);
}

bool ExperienceGraph::linkStarts(std::uint32_t from, std::uint32_t to) const {
  for (std::uint32_t k = experiences_.at(from).first_outgoing; k != kNoLink; k = links_[k].next_outgoing) {
    if (links_[k].to == to) return true;
  }
  return false;
}

}  // namespace ratslam
